// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/scene.hpp"

#include "core/material_file.hpp"
#include "simulate/simulated_body.hpp"
#include "tests/simulate/sample_scene.hpp"
#include "tests/support/expect_refusal.hpp"

#include <gtest/gtest.h>

#include <string>

namespace twang {
namespace {

using test::holds;
using test::kStripScene;
using test::refusal_of;
using test::SampleScene;
using test::with;

TEST(Scene, ReadsEveryKey) {
  const SampleScene sample(R"(format = "twang-scene/1"
name = "all keys"
duration_s = 0.25
step_s = 5e-4
gravity_m_s2 = [1.0, 2.0, -3.0]
integrator = "bdf2"
[[body]]
name = "a"
rig = "strip.toml"
dx_mm = 2.5
element = "hex20"
clamped = false
position_mm = [1.0, 2.0, 3.0]
rotation_deg = [0.0, 0.0, 90.0]
velocity_m_s = [0.1, 0.2, 0.3]
spin_rad_s = [4.0, 5.0, 6.0]
[body.material.part]
youngs_modulus_pa = 1e9
poissons_ratio = 0.3
density_kg_m3 = 1000.0
damping_stiffness_b_s = 1e-4
damping_mass_a_per_s = 7.0
model = "stvk"
[[body]]
name = "b"
rig = "strip.toml"
dx_mm = 5
material = {youngs_modulus_pa = 2e9}
[[load]]
body = "b"
marker = "tip"
force_n = [0.0, 0.0, 2.0]
release_s = 0.01
[[probe]]
body = "b"
marker = "tip"
[[base_motion]]
body = "b"
trace = "shake.csv"
z_column = "base.z_mm"
[output]
every_s = 1e-3
vtu = true
checkpoint_every_s = 0.05
)");
  sample.folder.write("shake.csv", "time_s,base.z_mm\n0,5\n0.1,6\n0.2,4\n");
  const Scene scene = load_scene(sample.scene);
  EXPECT_EQ(scene.duration_s, 0.25);
  EXPECT_EQ(scene.step_s, 5e-4);
  EXPECT_EQ(scene.gravity_m_s2, Eigen::Vector3d(1.0, 2.0, -3.0));
  EXPECT_EQ(scene.scheme, Scheme::Bdf2);
  ASSERT_EQ(scene.bodies.size(), 2U);
  const SceneBody& a = scene.bodies[0];
  EXPECT_EQ(a.name, "a");
  EXPECT_DOUBLE_EQ(a.dx_m, 2.5e-3);
  EXPECT_EQ(a.element, ElementKind::Hex20);
  EXPECT_FALSE(a.clamped);
  EXPECT_TRUE(a.position.isApprox(Eigen::Vector3d(1e-3, 2e-3, 3e-3)));
  EXPECT_TRUE((a.rotation * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_EQ(a.velocity_m_s, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(a.spin_rad_s, Eigen::Vector3d(4.0, 5.0, 6.0));
  EXPECT_EQ(a.model, ConstitutiveModel::SaintVenantKirchhoff);
  const ElasticMaterial& material = a.materials.at("part");
  EXPECT_EQ(material.youngs_modulus_pa, 1e9);
  EXPECT_EQ(material.poissons_ratio, 0.3);
  EXPECT_EQ(material.density_kg_m3, 1000.0);
  EXPECT_EQ(material.damping_stiffness_b_s, 1e-4);
  EXPECT_EQ(material.damping_mass_a_per_s, 7.0);
  const SceneBody& b = scene.bodies[1];
  EXPECT_TRUE(b.clamped);
  EXPECT_EQ(b.materials.at("part").density_kg_m3, 1180.0);  // the rig's
  ASSERT_EQ(scene.loads.size(), 1U);
  EXPECT_EQ(scene.loads[0].body, 1U);
  EXPECT_EQ(scene.loads[0].at, Eigen::Vector3d(0.038, 0.0, 0.002));
  EXPECT_EQ(scene.loads[0].force, Eigen::Vector3d(0.0, 0.0, 2.0));
  EXPECT_FALSE(scene.loads[0].displacement);
  EXPECT_EQ(scene.loads[0].release_s, 0.01);
  ASSERT_EQ(scene.probes.size(), 1U);
  EXPECT_EQ(scene.probes[0].marker, "tip");
  ASSERT_EQ(scene.base_motions.size(), 1U);
  EXPECT_TRUE(scene.base_motions[0].displacement.col(1).isApprox(Eigen::Vector3d(0, 0, 1e-3)));
  EXPECT_EQ(scene.output.every_s, 1e-3);
  EXPECT_TRUE(scene.output.vtu);
  EXPECT_EQ(scene.output.checkpoint_every_s, 0.05);
}

struct Fault {
  const char* name;
  const char* from;
  const char* to;
  const char* complaint;
};

class SceneRefusal : public testing::TestWithParam<Fault> {};

TEST_P(SceneRefusal, NamesPlaceValueAndWhatIsExpected) {
  const Fault& fault = GetParam();
  const SampleScene sample(with(kStripScene, fault.from, fault.to));
  const std::string message = refusal_of([&] { static_cast<void>(load_scene(sample.scene)); });
  EXPECT_TRUE(holds(message, fault.complaint));
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

INSTANTIATE_TEST_SUITE_P(
    Faults,
    SceneRefusal,
    testing::Values(
        Fault{
            "Format", "twang-scene/1", "twang-scene/2", "scene.toml:1: format is 'twang-scene/2'"},
        Fault{"UnknownKey", "duration_s", "duratoin_s", "scene.toml:2: duratoin_s is not a known"},
        Fault{"NearestKey", "duration_s", "duratoin_s", "(nearest: duration_s)"},
        Fault{"UnknownBodyKey", "dx_mm", "dy_mm", "body.1.dy_mm is not a known key"},
        Fault{"NoDuration", "duration_s = 4e-3", "", "duration_s is missing"},
        Fault{"StepZero", "step_s = 1e-4", "step_s = 0", "scene.toml:3: step_s is 0, must be > 0"},
        Fault{"StepBeyond", "step_s = 1e-4", "step_s = 1.0", "at most duration_s, 0.004"},
        Fault{"StepTiny", "step_s = 1e-4", "step_s = 1e-13", "fewer than 2e9 steps"},
        Fault{"StepNan", "step_s = 1e-4", "step_s = nan", "a finite number"},
        Fault{"Integrator", "\"newmark\"", "\"newmrk\"", "(nearest: newmark)"},
        Fault{"Gravity", "[0.0, 0.0, -9.81]", "[0.0, -9.81]", "three numbers"},
        Fault{"NoRig", "\"strip.toml\"", "\"none.toml\"", "none.toml: no such file"},
        Fault{"BodyName", "name = \"strip\"", "name = \"a,b\"", "without commas"},
        Fault{"Element", "\"hex8\"", "\"hex9\"", "element is 'hex9', must be one of"},
        Fault{"Dx", "dx_mm = 5.0", "dx_mm = -5.0", "body.1.dx_mm is -5, must be > 0"},
        Fault{"Modulus", "5e7", "-5e7", "body.1.material.youngs_modulus_pa is "},
        Fault{"MaterialKey", "damping_stiffness_b_s", "damping_b_s", "damping_b_s is not a known"},
        Fault{"Locked",
              "youngs_modulus_pa = 5e7",
              "youngs_modulus_pa = 5e7\npoissons_ratio = 0.5",
              "between -1 and 0.5"},
        Fault{"Velocity", "clamped = true", "velocity_m_s = [1, 0, 0]", "the body is clamped"},
        Fault{"FreeLoad", "clamped = true", "clamped = false", "a clamped body"},
        Fault{"LoadBody", "body = \"strip\"", "body = \"srtip\"", "(nearest: strip)"},
        Fault{"LoadPoint", "at_mm = [40.0, 5.0, 2.0]", "", "exactly one of at_mm and marker"},
        Fault{"LoadBoth", "release_s", "force_n = [1, 0, 0]\nrelease_s", "exactly one of displ"},
        Fault{"LoadZero", "[0.0, 0.0, -4.0]", "[0, 0, 0]", "not zero"},
        Fault{"Release", "release_s = 2e-4", "release_s = -1", "must be >= 0"},
        Fault{"Marker", "marker = \"tip\"", "marker = \"top\"", "(nearest: tip)"},
        Fault{"Every", "every_s = 5e-4", "every_s = 5e-5", "at least step_s"},
        Fault{"Vtu", "vtu = true", "vtu = 1", "true or false"}),
    [](const auto& instance) { return std::string(instance.param.name); });

TEST(Scene, RefusesWhatIsNoScene) {
  const SampleScene sample;
  const auto refusal = [&](const std::filesystem::path& path) {
    return refusal_of([&] { static_cast<void>(load_scene(path)); });
  };
  EXPECT_TRUE(holds(refusal(sample.folder / "none.toml"), "no such file"));
  EXPECT_TRUE(holds(refusal(sample.folder.write("empty.toml", "")), "is empty, must be a scene"));
  EXPECT_TRUE(holds(refusal(sample.folder / "strip.toml"), "twang-scene/1"));
}

/// A material whose E_n belongs to the sample's mesh of 8 x 2 x 1 cells of 5 mm.
Material calibrated() {
  Material material;
  material.material = "part";
  material.youngs_modulus_identified_pa = 2e9;
  material.youngs_modulus_numerical_pa = 1e9;
  material.numerical_element = "hex8";
  material.numerical_dx_mm = 5.0;
  material.numerical_elements = 16;
  material.rig_sha256 = "none";
  material.damping_stiffness_b_s = 1e-4;
  material.poissons_ratio = 0.4;
  material.density_kg_m3 = 1180.0;
  return material;
}

std::string with_file(const std::string& extra) {
  return with(kStripScene,
              "[body.material]\nyoungs_modulus_pa = 5e7\ndamping_stiffness_b_s = 1e-4\n",
              "material = \"material.json\"\n" + extra);
}

double modulus_in(const std::filesystem::path& path) {
  const Scene scene = load_scene(path);
  return SimulatedBody(scene, 0).body().materials().front().youngs_modulus_pa;
}

TEST(Scene, NumericalModulusIsRefusedOnAnotherMesh) {
  const SampleScene sample(with_file(""));
  const std::filesystem::path file = sample.folder / "material.json";
  write_material(file, calibrated());
  EXPECT_EQ(modulus_in(sample.scene), 1e9);
  for (const auto change : {+[](Material& m) { m.numerical_element = "hex8e"; },
                            +[](Material& m) { m.numerical_dx_mm = 5.1; },
                            +[](Material& m) { m.numerical_elements = 17; }}) {
    Material other = calibrated();
    change(other);
    write_material(file, other);
    const std::string message = refusal_of([&] { static_cast<void>(modulus_in(sample.scene)); });
    EXPECT_TRUE(holds(message, "whose numerical modulus belongs to a mesh of"));
    EXPECT_TRUE(holds(message, "scene.toml:12: body.1.material"));
  }
  // Another mesh does not matter to E.
  const SampleScene identified(with_file("modulus = \"identified\"\n"));
  Material other = calibrated();
  other.numerical_elements = 17;
  write_material(identified.folder / "material.json", other);
  EXPECT_EQ(modulus_in(identified.scene), 2e9);
}

TEST(Scene, FingerprintKnowsAllThatIsRead) {
  const SampleScene sample(with_file(""));
  write_material(sample.folder / "material.json", calibrated());
  const std::string first = load_scene(sample.scene).sha256;
  EXPECT_EQ(load_scene(sample.scene).sha256, first);
  Material other = calibrated();
  other.damping_stiffness_b_s = 2e-4;
  write_material(sample.folder / "material.json", other);
  const std::string second = load_scene(sample.scene).sha256;
  EXPECT_NE(second, first);
  sample.folder.write("strip.toml", std::string(test::kStripRig) + "# another\n");
  EXPECT_NE(load_scene(sample.scene).sha256, second);
}

}  // namespace
}  // namespace twang
