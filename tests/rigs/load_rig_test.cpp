// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/load_rig.hpp"

#include "core/sha256.hpp"
#include "tests/rigs/example_rig.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <string>

namespace twang {
namespace {

using Eigen::Vector3d;
using test::example_with;
using test::holds;
using test::kExampleRig;
using test::refusal_of;
using test::TemporaryFolder;

Rig load_text(std::string_view text, const RigNeeds& needs = {}) {
  const TemporaryFolder folder;
  return load_rig(folder.write("rig.toml", text), needs);
}

// Rounding of one conversion from millimetres, in metres.
constexpr double kRounding = 1e-15;

TEST(LoadRig, ReadsPartClampsAndMassesInSi) {
  const Rig rig = load_text(kExampleRig);
  ASSERT_EQ(rig.parts.size(), 2U);
  EXPECT_EQ(rig.parts[0].material, "part");
  EXPECT_EQ(rig.parts[1].material, "rubber");
  const Box& box = std::get<Box>(rig.parts[0].shape);
  EXPECT_TRUE(box.min.isZero());
  EXPECT_TRUE(box.max.isApprox(Vector3d(0.080, 0.010, 0.002), kRounding));
  const Cylinder& cylinder = std::get<Cylinder>(rig.parts[1].shape);
  EXPECT_TRUE(cylinder.from.isApprox(Vector3d(0.040, 0.005, 0.002), kRounding));
  EXPECT_TRUE(cylinder.to.isApprox(Vector3d(0.040, 0.005, 0.009), kRounding));
  EXPECT_DOUBLE_EQ(cylinder.radius, 0.003);
  ASSERT_EQ(rig.clamps.size(), 1U);
  EXPECT_TRUE(rig.clamps[0].max.isApprox(Vector3d(0.0, 0.010, 0.002), kRounding));
  ASSERT_EQ(rig.masses.size(), 1U);
  EXPECT_TRUE(rig.masses[0].at.isApprox(Vector3d(0.070, 0.005, 0.002), kRounding));
  EXPECT_DOUBLE_EQ(rig.masses[0].mass_kg, 0.00125);
  EXPECT_EQ(rig.masses[0].size, Vector3d::Zero());
  std::string text(kExampleRig);
  const std::string mass = "mass_g = 1.25";
  text.insert(text.find(mass), "size_mm = [4.0, 3.0, 0.0]\n");
  EXPECT_TRUE(load_text(text).masses.at(0).size.isApprox(Vector3d(0.004, 0.003, 0.0), kRounding));
}

TEST(LoadRig, ReadsMaterials) {
  const Rig rig = load_text(kExampleRig);
  ASSERT_EQ(rig.materials.size(), 2U);
  const RigMaterial* part = rig.find_material("part");
  ASSERT_NE(part, nullptr);
  EXPECT_EQ(part->density_kg_m3, 1180.0);
  EXPECT_EQ(part->poissons_ratio, 0.45);
  EXPECT_EQ(part->youngs_modulus_pa, 1.9e9);
  EXPECT_EQ(part->reported_youngs_modulus_pa, 2.1e9);
  const RigMaterial* rubber = rig.find_material("rubber");
  ASSERT_NE(rubber, nullptr);
  EXPECT_EQ(rubber->density_kg_m3, 1070.0);
  EXPECT_FALSE(rubber->youngs_modulus_pa.has_value());
  EXPECT_EQ(rig.find_material("wood"), nullptr);
}

TEST(LoadRig, ReadsMarkers) {
  const Rig rig = load_text(kExampleRig);
  ASSERT_EQ(rig.markers.size(), 3U);
  const Marker* tip = rig.find_marker("tip");
  ASSERT_NE(tip, nullptr);
  EXPECT_EQ(tip->kind, MarkerKind::Cross);
  EXPECT_DOUBLE_EQ(tip->size_m, 0.005);
  EXPECT_TRUE(tip->position.isApprox(Vector3d(0.076, 0.0, 0.001), kRounding));
  EXPECT_FALSE(tip->fixed);
  const Marker* bench = rig.find_marker("bench");
  ASSERT_NE(bench, nullptr);
  EXPECT_EQ(bench->kind, MarkerKind::Dot);
  EXPECT_TRUE(bench->fixed);
  EXPECT_TRUE(bench->position.isApprox(Vector3d(0.007, -0.030, 0.012), kRounding));
  const Marker* tag = rig.find_marker("tag");
  ASSERT_NE(tag, nullptr);
  EXPECT_EQ(tag->kind, MarkerKind::ArUco);
  EXPECT_EQ(tag->dictionary, "4x4_50");
  EXPECT_EQ(tag->tag, 17);
  EXPECT_FALSE(tag->fixed);
}

TEST(LoadRig, ReadsEveryKindOfMarker) {
  for (const MarkerKind kind : {MarkerKind::Cross,
                                MarkerKind::Dot,
                                MarkerKind::Ring,
                                MarkerKind::Checker,
                                MarkerKind::Patch,
                                MarkerKind::AprilTag,
                                MarkerKind::ArUco}) {
    std::string line = "kind = \"" + std::string(to_string(kind)) + "\"";
    if (kind == MarkerKind::ArUco) line += "\ndictionary = \"DICT_6X6_250\"\ntag = 249";
    if (kind == MarkerKind::AprilTag) line += "\ndictionary = \"tag36h11\"\ntag = 586";
    EXPECT_EQ(load_text(example_with("kind = \"cross\"", line)).find_marker("tip")->kind, kind);
  }
}

TEST(LoadRig, ReadsObservableReleaseAndCamera) {
  const Rig rig = load_text(kExampleRig);
  ASSERT_TRUE(rig.observable.has_value());
  EXPECT_EQ(rig.observable->kind, ObservableKind::Displacement);
  EXPECT_EQ(rig.observable->markers, std::vector<std::string>{"tip"});
  EXPECT_EQ(rig.observable->direction, Vector3d(0.0, 0.0, 2.0));
  ASSERT_TRUE(rig.release.has_value());
  EXPECT_TRUE(rig.release->at.isApprox(Vector3d(0.080, 0.005, 0.002), kRounding));
  ASSERT_TRUE(rig.release->displacement.has_value());
  EXPECT_TRUE(rig.release->displacement->isApprox(Vector3d(0.0, 0.0, -0.005), kRounding));
  EXPECT_FALSE(rig.release->force.has_value());
  ASSERT_TRUE(rig.camera.has_value());
  EXPECT_EQ(rig.camera->capture_fps, 240.0);
  EXPECT_EQ(rig.camera->image_right, Vector3d(0.0, 1.0, 0.0)) << "made a unit vector";
  EXPECT_EQ(rig.camera->image_down, Vector3d(0.0, 0.0, -1.0));
  EXPECT_DOUBLE_EQ(rig.camera->readout_s, 0.004);
  EXPECT_EQ(rig.camera->lens, rig.file.parent_path() / "phone.yml");
}

TEST(LoadRig, ReadsToleranceGravityAndSpecimen) {
  const Rig rig = load_text(kExampleRig);
  EXPECT_DOUBLE_EQ(rig.tolerance.dimension_m, 85e-6);
  EXPECT_EQ(rig.tolerance.density_rel, 0.01);
  EXPECT_EQ(rig.tolerance.poissons_ratio, 0.02);
  EXPECT_EQ(rig.tolerance.clock_rel, 1e-4);
  ASSERT_TRUE(rig.gravity_m_s2.has_value());
  EXPECT_EQ(*rig.gravity_m_s2, Vector3d(0.1, 0.2, -9.81));
  const std::map<std::string, std::string> expected = {{"batch", "A7"},
                                                       {"printer", "P"},
                                                       {"orientation", "flat"},
                                                       {"infill", "100"},
                                                       {"cure", "2 h"},
                                                       {"temperature_c", "21.5"},
                                                       {"printed_on", "2024-03-01"},
                                                       {"tested_on", "2024-03-04"},
                                                       {"note", "first of five"}};
  EXPECT_EQ(rig.specimen, expected);
}

TEST(LoadRig, RemembersFileAndFingerprint) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("rig.toml", kExampleRig);
  const Rig rig = load_rig(path);
  EXPECT_EQ(rig.name, "strip 80x10x2");
  EXPECT_EQ(rig.file, path);
  EXPECT_EQ(rig.sha256, sha256_of_text(kExampleRig));
}

TEST(LoadRig, NeedsNoMoreThanFormatAndName) {
  const Rig rig = load_text("format = \"twang-rig/1\"\nname = \"bare\"\n");
  EXPECT_TRUE(rig.parts.empty());
  EXPECT_FALSE(rig.camera || rig.observable || rig.release || rig.gravity_m_s2);
  EXPECT_EQ(rig.tolerance.dimension_m, 0.0);
  EXPECT_EQ(rig.tolerance.clock_rel, 0.0);
}

TEST(LoadRig, ReadsAnAngleBetweenTwoMarkers) {
  const Rig rig = load_text(
      example_with("kind = \"displacement\"\nmarker = \"tip\"\ndirection = [0.0, 0.0, 2.0]",
                   "kind = \"angle\"\nmarkers = [\"tag\", \"tip\"]"));
  EXPECT_EQ(rig.observable->kind, ObservableKind::Angle);
  EXPECT_EQ(rig.observable->markers, (std::vector<std::string>{"tag", "tip"}));
}

TEST(LoadRig, ReadsAReleaseByForce) {
  const Rig rig =
      load_text(example_with("displacement_mm = [0.0, 0.0, -5.0]", "force_n = [0.5, 0.0, -2.0]"));
  EXPECT_FALSE(rig.release->displacement.has_value());
  EXPECT_EQ(rig.release->force, Vector3d(0.5, 0.0, -2.0));
}

TEST(LoadRig, StraightensImageAxesThatAreSkewByRounding) {
  const Rig rig =
      load_text(example_with("image_down = [0.0, 0.0, -1.0]", "image_down = [0.0, 1e-7, -2.0]"));
  EXPECT_EQ(rig.camera->image_right.dot(rig.camera->image_down), 0.0);
  EXPECT_DOUBLE_EQ(rig.camera->image_down.norm(), 1.0);
}

TEST(LoadRig, AcceptsAMarkerJustWithinAMillimetreOfTheSurface) {
  for (const char* position : {"[76.0, -1.0, 1.0]",
                               "[81.0, 5.0, 2.0]",
                               "[76.0, 1.0, 1.0]",
                               "[40.0, 5.0, 10.0]",
                               "[44.0, 5.0, 6.0]",
                               "[42.1, 5.0, 6.0]"}) {
    EXPECT_NO_THROW((void)load_text(
        example_with("position_mm = [76.0, 0.0, 1.0]", std::string("position_mm = ") + position)))
        << position;
  }
}

TEST(LoadRig, TakesTheSurfaceOfTheUnionForAMarkersDistance) {
  const std::string stacked = R"(format = "twang-rig/1"
name = "two blocks"
materials.m = {density_kg_m3 = 1e3, poissons_ratio = 0.3}
part = [{material = "m", shape = "box", min_mm = [0, 0, 0], max_mm = [20, 20, 10]},
        {material = "m", shape = "box", min_mm = [0, 0, 10], max_mm = [20, 20, 20]}]
marker = [{id = "a", kind = "dot", size_mm = 3, position_mm = POSITION}]
)";
  const auto at = [&](const char* position) {
    std::string text = stacked;
    return text.replace(text.find("POSITION"), 8, position);
  };
  EXPECT_NO_THROW((void)load_text(at("[10, 0, 10]")));
  // On the face that the blocks share: the surface of each, but deep inside both together.
  const std::string message = refusal_of([&] { (void)load_text(at("[10, 10, 10]")); });
  EXPECT_TRUE(holds(message, "rig.toml:6: marker.1.position_mm is ")) << message;
}

TEST(LoadRig, AsksForTheTablesACommandNeeds) {
  const std::string bare = "format = \"twang-rig/1\"\nname = \"bare\"\n";
  const auto refusal = [&](const RigNeeds& needs, const std::string& more) {
    return refusal_of([&] { (void)load_text(bare + more, needs); });
  };
  EXPECT_TRUE(holds(refusal({.part = true}, ""), "rig.toml: [materials.NAME] is missing"));
  EXPECT_TRUE(
      holds(refusal({.part = true}, "materials.m = {density_kg_m3 = 1, poissons_ratio = 0}"),
            "[[part]] is missing"));
  EXPECT_TRUE(holds(refusal({.clamp = true}, ""), "rig.toml: [[clamp]] is missing"));
  EXPECT_TRUE(holds(refusal({.film = true}, ""), "[[marker]] is missing"));
  EXPECT_TRUE(holds(
      refusal({.film = true},
              "marker = [{id = \"a\", kind = \"dot\", size_mm = 3, position_mm = [0, 0, 0]}]"),
      "[camera] is missing"));
  EXPECT_TRUE(holds(refusal({.observable = true}, ""), "[observable] is missing"));
  EXPECT_TRUE(holds(refusal({.part = true}, "part = []\nmaterials = {}"), "is missing"));
  EXPECT_NO_THROW((void)load_text(kExampleRig,
                                  {.part = true, .clamp = true, .film = true, .observable = true}));
}

TEST(LoadRig, AnswersEveryDamagedFileWithARigOrOneSentence) {
  const TemporaryFolder folder;
  std::mt19937 random(11);
  const auto below = [&](std::size_t bound) {
    return std::uniform_int_distribution<std::size_t>(0, bound - 1)(random);
  };
  const std::string_view alphabet = "[]{}\"'=.,#-+_ \n\t09azmin\x01\xff";
  int refused = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::string text(kExampleRig);
    for (std::size_t damage = 1 + below(3); damage > 0; --damage) {
      const std::size_t at = below(text.size());
      if (below(3) == 0) {
        text.erase(at, 1 + below(30));
      } else {
        text.insert(at, 1, alphabet[below(alphabet.size())]);
      }
    }
    const std::filesystem::path path = folder.write("rig.toml", text);
    try {
      (void)load_rig(path);
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_TRUE(message.starts_with(path.string() + ":")) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      ++refused;
    }
  }
  EXPECT_GT(refused, 100) << "too little damage proves nothing";
}

TEST(LoadRig, RefusesWhatIsNoRigFileInOneSentence) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::filesystem::path& path) {
    const std::string message = refusal_of([&] { (void)load_rig(path); });
    EXPECT_TRUE(message.starts_with(path.string() + ":")) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  };
  EXPECT_TRUE(holds(refusal(folder.path() / "none.toml"), "no such file"));
  EXPECT_TRUE(holds(refusal(folder.path()), "is a folder"));
  EXPECT_TRUE(holds(refusal(folder.write("empty.toml", "")), "is empty"));
  EXPECT_TRUE(holds(refusal(folder.write("blank.toml", " \n\n")), "is empty"));
  EXPECT_TRUE(holds(refusal(folder.write("zero.toml", std::string("a\0b", 3))), "binary"));
  EXPECT_TRUE(holds(refusal(folder.write("latin.toml", "format = \"\xe9\xff\"\n")), ":1: "));
  EXPECT_TRUE(holds(refusal(folder.write("comment.toml", "# none\n")), "format is missing"));
  EXPECT_TRUE(holds(refusal(folder.write("open.toml", "format = \"twang-rig/1\"\nname = [1,\n")),
                    "open.toml:"));
  EXPECT_TRUE(holds(
      refusal(folder.write("twice.toml", "format = \"twang-rig/1\"\nname = \"a\"\nname = \"b\"\n")),
      "twice.toml:3: "));
}

}  // namespace
}  // namespace twang
