// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/marker_pattern.hpp"
#include "rigs/marker_dictionary.hpp"
#include "tests/support/expect_refusal.hpp"

#include <apriltag/apriltag.h>
#include <apriltag/common/image_u8.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h10.h>
#include <apriltag/tag36h11.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace twang::test {
namespace {

Marker tag_marker(MarkerKind kind, const std::string& dictionary, int tag) {
  Marker marker;
  marker.id = "tip";
  marker.kind = kind;
  marker.dictionary = dictionary;
  marker.tag = tag;
  return marker;
}

/// Rows of cells, '#' for ink.
std::vector<std::string> cells_of(const MarkerPattern& pattern) {
  std::vector<std::string> rows;
  for (int row = 0; row < pattern.num_cells(); ++row) {
    std::string& line = rows.emplace_back();
    for (int column = 0; column < pattern.num_cells(); ++column) {
      line += pattern.ink(row, column) ? '#' : '.';
    }
  }
  return rows;
}

std::vector<std::string> cells_of(MarkerKind kind, const std::string& dictionary, int tag) {
  return cells_of(MarkerPattern(tag_marker(kind, dictionary, tag)));
}

struct Family {
  const char* name;
  apriltag_family_t* (*create)();
  void (*destroy)(apriltag_family_t*);
};

/// What libapriltag draws, without the paper around.
std::vector<std::string> drawn_by_libapriltag(apriltag_family_t* family, int tag) {
  const std::unique_ptr<image_u8_t, void (*)(image_u8_t*)> image(apriltag_to_image(family, tag),
                                                                 image_u8_destroy);
  std::vector<std::string> rows;
  for (int y = 1; y + 1 < image->height; ++y) {
    std::string& line = rows.emplace_back();
    for (int x = 1; x + 1 < image->width; ++x) {
      line += image->buf[y * image->stride + x] == 0 ? '#' : '.';
    }
  }
  return rows;
}

TEST(TagCells, OfAprilTagsAreWhatLibapriltagDraws) {
  for (const Family& known : {Family{"tag16h5", tag16h5_create, tag16h5_destroy},
                              Family{"tag25h9", tag25h9_create, tag25h9_destroy},
                              Family{"tag36h10", tag36h10_create, tag36h10_destroy},
                              Family{"tag36h11", tag36h11_create, tag36h11_destroy}}) {
    apriltag_family_t* family = known.create();
    const MarkerDictionary* dictionary = find_marker_dictionary(MarkerKind::AprilTag, known.name);
    ASSERT_NE(dictionary, nullptr) << known.name;
    const int count = static_cast<int>(family->ncodes);
    EXPECT_EQ(dictionary->num_tags, count) << known.name;
    for (const int tag : {0, 1, 17, count / 2, count - 1}) {
      EXPECT_EQ(cells_of(MarkerKind::AprilTag, known.name, tag), drawn_by_libapriltag(family, tag))
          << known.name << " " << tag;
    }
    known.destroy(family);
  }
}

TEST(TagCells, OfArucoTagsAreThoseOfOpenCv) {
  // As cv::aruco::drawMarker of OpenCV 4.6 draws them.
  using Rows = std::vector<std::string>;
  const auto cells = [](const char* dictionary, int tag) {
    return cells_of(MarkerKind::ArUco, dictionary, tag);
  };
  EXPECT_EQ(cells("DICT_4X4_50", 0),
            Rows({"######", "#.#..#", "##.#.#", "###..#", "###.##", "######"}));
  EXPECT_EQ(cells("DICT_5X5_100", 99),
            Rows({"#######", "###.###", "##.##.#", "####..#", "#.#...#", "#...#.#", "#######"}));
  EXPECT_EQ(cells("DICT_6X6_250", 23),
            Rows({"########",
                  "#.##..##",
                  "#.##.#.#",
                  "###....#",
                  "##..##.#",
                  "#..##..#",
                  "#..##..#",
                  "########"}));
  EXPECT_EQ(cells("DICT_7X7_1000", 999),
            Rows({"#########",
                  "#...##..#",
                  "#....##.#",
                  "#.#.##.##",
                  "#..#...##",
                  "###.#####",
                  "###..#.##",
                  "##......#",
                  "#########"}));
  EXPECT_EQ(cells("DICT_ARUCO_ORIGINAL", 77),
            Rows({"#######", "#.#####", "#.#...#", "#.#####", "##...##", "#.#...#", "#######"}));
}

/// Python with OpenCV's ArUco module draws tags: lines "name tag cells", nothing without it.
std::string drawn_by_opencv() {
  constexpr const char* kScript =
      "/usr/bin/python3 -c '\n"
      "import cv2\n"
      "from cv2 import aruco\n"
      "for name in dir(aruco):\n"
      "    if not name.startswith(\"DICT_\") or \"APRIL\" in name: continue\n"
      "    dictionary = aruco.getPredefinedDictionary(getattr(aruco, name))\n"
      "    side, count = dictionary.markerSize + 2, len(dictionary.bytesList)\n"
      "    for tag in list(range(0, count, 7)) + [count - 1]:\n"
      "        picture = aruco.drawMarker(dictionary, tag, 4 * side)[2::4, 2::4]\n"
      "        print(name, tag, \"\".join(\"#.\"[int(x > 127)] for x in picture.flatten()))\n"
      "print(\"done\")\n"
      "' 2>/dev/null";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(kScript, "r"), pclose);
  std::string text;
  std::array<char, 4096> buffer{};
  while (pipe && std::fgets(buffer.data(), buffer.size(), pipe.get()) != nullptr) {
    text += buffer.data();
  }
  return text.ends_with("done\n") ? text : "";
}

TEST(TagCells, OfEveryArucoDictionaryAreWhatOpenCvDraws) {
  const std::string drawn = drawn_by_opencv();
  if (drawn.empty()) GTEST_SKIP() << "needs /usr/bin/python3 with OpenCV's ArUco (python3-opencv)";
  std::istringstream lines(drawn);
  int compared = 0;
  std::string name, cells;
  for (int tag = 0; lines >> name >> tag >> cells;) {
    std::string ours;
    for (const std::string& row : cells_of(MarkerKind::ArUco, name, tag)) ours += row;
    EXPECT_EQ(ours, cells) << name << " " << tag;
    ++compared;
  }
  EXPECT_GT(compared, 900);  // of 6624 tags every seventh
}

TEST(TagCells, FillTheSquareAsTheyStand) {
  const MarkerPattern pattern(tag_marker(MarkerKind::ArUco, "DICT_6X6_250", 23));
  ASSERT_EQ(pattern.num_cells(), 8);
  int ink = 0;
  for (int row = 0; row < 8; ++row) {
    for (int column = 0; column < 8; ++column) {
      const double x = (column + 0.5) / 8.0 - 0.5;
      const double y = (row + 0.5) / 8.0 - 0.5;
      EXPECT_EQ(pattern.value(x, y), pattern.ink(row, column) ? 0.0 : 1.0);
      EXPECT_NEAR(pattern.averaged(x, y, 0.1), pattern.value(x, y), 1e-12);  // rounding
      ink += pattern.ink(row, column) ? 1 : 0;
    }
  }
  EXPECT_NEAR(pattern.averaged(0.0, 0.0, 1.0), 1.0 - ink / 64.0, 1e-12);  // rounding
  EXPECT_EQ(pattern.value(0.51, 0.0), 1.0);
  // Half of it lies beyond the border, which is ink.
  EXPECT_NEAR(pattern.averaged(0.5, 0.0, 0.1), 0.5, 1e-12);
}

TEST(TagCells, AreCalledByTheNamesPeopleUse) {
  const auto rows = cells_of(MarkerKind::ArUco, "DICT_4X4_50", 17);
  for (const char* name : {"4x4_50", "4X4_50", "dict_4x4_50", "DICT_4X4_1000"}) {
    EXPECT_EQ(cells_of(MarkerKind::ArUco, name, 17), rows) << name;
  }
  EXPECT_EQ(cells_of(MarkerKind::AprilTag, "36h11", 5),
            cells_of(MarkerKind::AprilTag, "tag36h11", 5));
  EXPECT_EQ(cells_of(MarkerKind::ArUco, "aruco_original", 5),
            cells_of(MarkerKind::ArUco, "DICT_ARUCO_ORIGINAL", 5));
}

TEST(TagCells, OfAprilTagsAreKnownByOpenCvsNamesToBothKinds) {
  for (const std::string family : {"16h5", "25h9", "36h10", "36h11"}) {
    for (const int tag : {0, 7, 29}) {
      const auto rows = cells_of(MarkerKind::AprilTag, "tag" + family, tag);
      for (const char* name : {"DICT_APRILTAG_", "dict_apriltag_", "APRILTAG_"}) {
        EXPECT_EQ(cells_of(MarkerKind::AprilTag, name + family, tag), rows) << name << family;
        EXPECT_EQ(cells_of(MarkerKind::ArUco, name + family, tag), rows) << name << family;
      }
    }
  }
}

TEST(TagCells, UnknownDictionaryOrTagIsRefused) {
  const auto refusal = [](MarkerKind kind, const char* dictionary, int tag) {
    return refusal_of([&] { (void)MarkerPattern(tag_marker(kind, dictionary, tag)); });
  };
  EXPECT_TRUE(holds(refusal(MarkerKind::ArUco, "DICT_8X8_50", 0),
                    "marker 'tip': dictionary is 'DICT_8X8_50', must be one of DICT_4X4_50, "));
  EXPECT_TRUE(holds(refusal(MarkerKind::AprilTag, "tagStandard41h12", 0),
                    "must be one of tag16h5, tag25h9, tag36h10, tag36h11"));
  EXPECT_TRUE(holds(refusal(MarkerKind::ArUco, "tag36h11", 0), "must be one of DICT_"));
  EXPECT_TRUE(holds(refusal(MarkerKind::ArUco, "tag36h11", 0),
                    "DICT_APRILTAG_36h11 (it is known to kind = \"apriltag\")"));
  EXPECT_TRUE(holds(refusal(MarkerKind::AprilTag, "DICT_4X4_50", 0),
                    "must be one of tag16h5, tag25h9, tag36h10, tag36h11 (it is known to kind = "
                    "\"aruco\")"));
  for (const char* name : {"DICT_ARUCO_MIP_36h12", "DICT_36h11", "DICT_tag36h11", "", "DICT_"}) {
    const std::string refused = refusal(MarkerKind::ArUco, name, 0);
    EXPECT_TRUE(holds(refused, "must be one of DICT_4X4_50, ")) << name;
    EXPECT_TRUE(refused.ends_with("DICT_APRILTAG_36h10, DICT_APRILTAG_36h11")) << refused;
  }
  EXPECT_TRUE(holds(refusal(MarkerKind::ArUco, "4x4_50", 50),
                    "marker 'tip': tag is 50, must be 0 to 49 in DICT_4X4_50"));
  EXPECT_TRUE(holds(refusal(MarkerKind::AprilTag, "tag36h11", 587), "0 to 586"));
  EXPECT_TRUE(holds(refusal(MarkerKind::AprilTag, "tag36h11", -1), "tag is -1"));
}

}  // namespace
}  // namespace twang::test
