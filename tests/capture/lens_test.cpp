// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/lens.hpp"

#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

const fs::path kData = fs::path(TWANG_SOURCE_DIR) / "tests/data/lens";

struct GoldenPoint {
  Eigen::Vector2d ideal, seen;
};

std::vector<GoldenPoint> golden_points(const std::string& lens) {
  std::vector<GoldenPoint> points;
  std::ifstream file(kData / "points.csv");
  std::string line;
  while (std::getline(file, line)) {
    std::istringstream row(line);
    std::string name;
    char comma = 0;
    GoldenPoint point;
    if (!std::getline(row, name, ',') || name != lens) continue;
    row >> point.ideal.x() >> comma >> point.ideal.y() >> comma >> point.seen.x() >> comma >>
        point.seen.y();
    points.push_back(point);
  }
  return points;
}

class OpenCvLens : public ::testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] static Lens lens() { return read_lens(kData / (std::string(GetParam()) + ".yml")); }
  [[nodiscard]] static std::vector<GoldenPoint> points() { return golden_points(GetParam()); }
};

TEST_P(OpenCvLens, BendsAndStraightensAsOpenCvDoes) {
  ASSERT_EQ(points().size(), 30U);
  for (const GoldenPoint& point : points()) {
    // OpenCV's own two directions agree to 1e-12 px; the file has 15 digits.
    EXPECT_LT((lens().distorted(point.ideal) - point.seen).norm(), 1e-10);
    EXPECT_LT((lens().undistorted(point.seen) - point.ideal).norm(), 1e-9);
  }
}

TEST_P(OpenCvLens, RoundTripReturnsToANanometreOfAPixel) {
  const Lens bent = lens();
  for (int y = 0; y < bent.height_px; y += 37) {
    for (int x = 0; x < bent.width_px; x += 41) {
      const Eigen::Vector2d seen(x, y);
      EXPECT_LT((bent.distorted(bent.undistorted(seen)) - seen).norm(), 1e-9) << x << ' ' << y;
    }
  }
}

TEST_P(OpenCvLens, JacobianIsTheDerivative) {
  const Lens bent = lens();
  constexpr double kStep = 1e-2;  // [px]
  for (const GoldenPoint& point : points()) {
    const Eigen::Matrix2d jacobian = bent.distortion_jacobian(point.ideal);
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector2d way = kStep * Eigen::Vector2d::Unit(k);
      const Eigen::Vector2d slope =
          (bent.distorted(point.ideal + way) - bent.distorted(point.ideal - way)) / (2.0 * kStep);
      // Central differences: round-off of 1e-13 px over the step.
      EXPECT_LT((slope - jacobian.col(k)).norm(), 1e-8);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    AllModels,
    OpenCvLens,
    ::testing::Values("four", "five", "rational", "prism", "tilted", "fisheye"),
    [](const auto& lens) { return std::string(lens.param); });

constexpr const char* kSound =
    "image_width: 640\nimage_height: 360\n"
    "camera_matrix: [600, 0, 310, 0, 610, 170, 0, 0, 1]\n"
    "distortion_coefficients: [-0.2, 0.03, 0.001, -0.002]\n";

class CameraFile : public ::testing::Test {
 protected:
  Lens read(const std::string& text, const std::string& name = "phone.yml") {
    return read_lens(m_folder.write(name, text));
  }
  std::string refusal(const std::string& text) {
    const std::string message = refusal_of([&] { static_cast<void>(read(text)); });
    EXPECT_TRUE(holds(message, "phone.yml: "));
    EXPECT_EQ(message.find('\n'), std::string::npos);
    return message;
  }
  /// The sound file with one line replaced.
  std::string refusal(const std::string& key, const std::string& line) {
    std::string text;
    std::istringstream lines(kSound);
    for (std::string each; std::getline(lines, each);) {
      text += (each.rfind(key + ":", 0) == 0 ? line : each) + "\n";
    }
    return refusal(text);
  }
  TemporaryFolder m_folder;
};

TEST_F(CameraFile, EveryDialectTellsTheSame) {
  const Lens plain = read(kSound);
  EXPECT_EQ(plain.width_px, 640);
  EXPECT_EQ(plain.height_px, 360);
  EXPECT_EQ(plain.focal_px, Eigen::Vector2d(600.0, 610.0));
  EXPECT_EQ(plain.centre_px, Eigen::Vector2d(310.0, 170.0));
  EXPECT_EQ(plain.coefficients[0], -0.2);
  EXPECT_EQ(plain.coefficients[3], -0.002);
  const std::vector<std::string> dialects = {
      // ROS camera_info
      "image_width: 640\nimage_height: 360\ncamera_name: phone\n"
      "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [600, 0, 310, 0, 610, 170, 0, 0, 1]\n"
      "distortion_model: plumb_bob\n"
      "distortion_coefficients:\n  rows: 1\n  cols: 4\n  data: [-0.2, 0.03, 0.001, -0.002]\n",
      // OpenCV's JSON
      R"({"image_width": 640, "image_height": 360, "camera_matrix": {"type_id": "opencv-matrix",
"rows": 3, "cols": 3, "dt": "d", "data": [600.0, 0.0, 310.0, 0.0, 610.0, 170.0, 0.0, 0.0, 1.0]},
"dist_coeffs": {"type_id": "opencv-matrix", "rows": 1, "cols": 4, "dt": "d",
"data": [-0.2, 0.03, 0.001, -0.002]}})",
      // OpenCV's XML
      R"(<?xml version="1.0"?><opencv_storage><image_width>640</image_width>
<image_height>360</image_height><camera_matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols>
<dt>d</dt><data>600. 0. 310. 0. 610. 170. 0. 0. 1.</data></camera_matrix>
<distortion_coefficients type_id="opencv-matrix"><rows>4</rows><cols>1</cols><dt>d</dt>
<data>-0.2 0.03 0.001 -0.002</data></distortion_coefficients></opencv_storage>)"};
  for (const std::string& text : dialects) {
    const Lens lens = read(text);
    EXPECT_EQ(lens.model, LensModel::Polynomial);
    EXPECT_EQ(lens.width_px, plain.width_px);
    EXPECT_EQ(lens.height_px, plain.height_px);
    EXPECT_EQ(lens.focal_px, plain.focal_px);
    EXPECT_EQ(lens.centre_px, plain.centre_px);
    EXPECT_EQ(lens.coefficients, plain.coefficients);
  }
}

TEST_F(CameraFile, FisheyeIsSaidByItsModel) {
  EXPECT_EQ(read(std::string(kSound) + "distortion_model: equidistant\n").model,
            LensModel::Fisheye);
  EXPECT_EQ(read(std::string(kSound) + "fisheye_model: 1\n").model, LensModel::Fisheye);
  EXPECT_EQ(read(std::string(kSound) + "fisheye_model: 0\n").model, LensModel::Polynomial);
}

TEST_F(CameraFile, BadOnesAreRefusedInOneSentence) {
  EXPECT_TRUE(holds(refusal(""), "is empty"));
  EXPECT_TRUE(holds(refusal("no calibration at all"), "cannot be read"));
  EXPECT_TRUE(holds(refusal("other: 1\n"), "image_width is missing"));
  EXPECT_TRUE(holds(refusal("%YAML:1.0\n---\na: [1, 2\nb: {"), "cannot be read"));
  EXPECT_TRUE(holds(refusal("{\"image_width\": "), "cannot be read"));
  EXPECT_TRUE(holds(refusal("<opencv_storage><image_width>"), "cannot be read"));
  EXPECT_TRUE(holds(refusal(std::string("a\0b", 3)), "is no text file"));
  EXPECT_TRUE(holds(refusal("image_width", "image_width: 0"), "image_width is 0"));
  EXPECT_TRUE(holds(refusal("image_height", "image_height: wide"), "image_height is no number"));
  EXPECT_TRUE(holds(refusal("camera_matrix", ""), "camera_matrix is missing"));
  EXPECT_TRUE(holds(refusal("camera_matrix", "camera_matrix: [600, 0, 310, 0, 610]"),
                    "camera_matrix is 600, 0, 310, 0, 610"));
  EXPECT_TRUE(holds(refusal("camera_matrix", "camera_matrix: [-6, 0, 310, 0, 6, 170, 0, 0, 1]"),
                    "f_x and f_y > 0"));
  EXPECT_TRUE(holds(refusal("distortion_coefficients", "distortion_coefficients: [0.1, 0.2, 0.3]"),
                    "has 3 entries, must be 4, 5, 8, 12 or 14"));
  EXPECT_TRUE(
      holds(refusal("distortion_coefficients", "distortion_coefficients: [0.1, .Nan, 0.3, 0]"),
            "finite numbers"));
  EXPECT_TRUE(holds(refusal("distortion_coefficients",
                            "distortion_coefficients: [0.1, 0, 0, 0]\ndistortion_model: odd"),
                    "distortion_model is 'odd'"));
  // At r = 0.6 the radius no longer grows.
  EXPECT_TRUE(holds(refusal("distortion_coefficients", "distortion_coefficients: [-1.5, 0, 0, 0]"),
                    "folds the picture over"));
  EXPECT_TRUE(holds(refusal_of([&] { static_cast<void>(read_lens(m_folder / "none.yml")); }),
                    "none.yml: no such file"));
}

TEST_F(CameraFile, DamagedBytesAreRefusedOrRead) {
  std::mt19937 random(1);
  const std::string json =
      R"({"image_width": 64, "image_height": 36, "camera_matrix": {"type_id": "opencv-matrix",
"rows": 3, "cols": 3, "dt": "d", "data": [60.0, 0.0, 31.0, 0.0, 61.0, 17.0, 0.0, 0.0, 1.0]},
"dist_coeffs": [-0.2, 0.03, 0.001, -0.002]})";
  int refused = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::string text = trial % 2 == 0 ? kSound : json;
    for (int flips = 0; flips < 3; ++flips) {
      text[random() % text.size()] = static_cast<char>(random() % 256);
    }
    if (trial % 5 == 0) text.resize(random() % text.size());
    try {
      EXPECT_GT(read(text).width_px, 0);
    } catch (const InputError& error) {
      EXPECT_TRUE(holds(error.what(), "phone.yml: "));
      ++refused;
    }
  }
  EXPECT_GT(refused, 40);
}

TEST_F(CameraFile, ScalesWithThePictureAndRefusesAnotherProportion) {
  const Lens lens = read(kSound);
  const Lens twice = lens_for_size(lens, 1280, 720);
  // The same spot of the sensor: pixel p of the small picture is centred at 2 p + 0.5.
  const Eigen::Vector2d small(17.0, 301.0);
  const Eigen::Vector2d large = 2.0 * small.array() + 0.5;
  const Eigen::Vector2d expected = 2.0 * lens.undistorted(small).array() + 0.5;
  EXPECT_LT((twice.undistorted(large) - expected).norm(), 1e-9);
  EXPECT_EQ(lens_for_size(lens, 320, 181).height_px, 181);  // an odd size, rounded up
  for (const auto& [width, height] : {std::pair{360, 640}, {640, 480}, {1280, 724}}) {
    const std::string message =
        refusal_of([&, w = width, h = height] { static_cast<void>(lens_for_size(lens, w, h)); });
    EXPECT_TRUE(holds(message, "640 x 360 px"));
    EXPECT_TRUE(holds(message, std::to_string(width) + " x " + std::to_string(height)));
  }
}

}  // namespace
}  // namespace twang::test
