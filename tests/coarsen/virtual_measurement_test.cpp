// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/virtual_measurement.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/material_file.hpp"
#include "tests/coarsen/rigs_of_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

namespace twang {
namespace {

using Eigen::Vector3d;
using test::mm;
using test::small_ladder;

constexpr double kStated_pa = 1.7e9;
constexpr double kB_s = 3e-5;

Rig stated_beam() {
  Rig rig = test::beam(mm(40, 10, 5), 0.3, 1000.0);
  rig.materials.front().youngs_modulus_pa = kStated_pa;
  rig.sha256 = "0123";
  return rig;
}

double first_lambda(Rig rig, const MeshLadder& ladder, double modulus_pa) {
  rig.materials.front().youngs_modulus_pa = modulus_pa;
  const HexMesh& mesh = ladder.coarse.mesh;
  return compute_rung(rig, mesh.requested_dx_m, mesh.kind, 1).modes.lambda_per_s2(0);
}

TEST(VirtualMeasurement, TheCoarseMeshAtTheNumericalModulusVibratesAsTheLimitAtTheStatedOne) {
  const Rig rig = stated_beam();
  const MeshLadder ladder = build_mesh_ladder(rig, small_ladder());
  const Material material = measure_virtually(rig, ladder, kB_s).front();
  EXPECT_EQ(material.youngs_modulus_identified_pa, kStated_pa);
  EXPECT_LT(material.youngs_modulus_numerical_pa, 0.99 * kStated_pa);  // hex8 is too stiff
  // eigenvalues are found to 1e-10
  EXPECT_NEAR(first_lambda(rig, ladder, material.youngs_modulus_numerical_pa) /
                  (kStated_pa * ladder.limit.lambda_per_s2),
              1.0,
              1e-8);
  const double lambda = material.lambda_per_s2;
  EXPECT_NEAR(material.decay_per_s, 0.5 * kB_s * lambda, 1e-12 * lambda);
  EXPECT_NEAR(std::pow(kTwoPi * material.frequency_hz, 2) + std::pow(material.decay_per_s, 2),
              lambda,
              1e-9 * lambda);
  EXPECT_EQ(material.uncertainty.total(), ladder.limit.relative_sigma);
  EXPECT_EQ(material.youngs_modulus_identified_sigma_pa, kStated_pa * ladder.limit.relative_sigma);
  EXPECT_EQ(material.numerical_elements, ladder.coarse.mesh.num_elements());
}

TEST(VirtualMeasurement, SagsUnderGravityOnBothMeshes) {
  Rig rig = stated_beam();
  rig.materials.front().youngs_modulus_pa = 2e5;  // droops by a tenth of its length
  rig.gravity_m_s2 = Vector3d(0.0, 0.0, -9.81);
  const MeshLadder ladder = build_mesh_ladder(rig, small_ladder());
  const Material with = measure_virtually(rig, ladder).front();
  rig.gravity_m_s2.reset();
  const Material without = measure_virtually(rig, ladder).front();
  EXPECT_GT(std::abs(with.lambda_per_s2 / without.lambda_per_s2 - 1.0), 1e-4);
  // The coarse mesh is stiffened by its droop as the reference is: the moduli hardly differ.
  EXPECT_NEAR(with.youngs_modulus_numerical_pa / without.youngs_modulus_numerical_pa, 1.0, 0.01);
  EXPECT_NE(with.youngs_modulus_numerical_pa, without.youngs_modulus_numerical_pa);
}

TEST(VirtualMeasurement, RescalesSeveralMaterialsAlike) {
  Rig rig = stated_beam();
  RigMaterial soft = rig.materials.front();
  soft.name = "soft";
  soft.youngs_modulus_pa = 4e8;
  rig.materials.push_back(soft);
  rig.parts.push_back({"soft", Box{mm(20, 0, 0), mm(40, 10, 5)}});
  const MeshLadder ladder = build_mesh_ladder(rig, small_ladder());
  const std::vector<Material> materials = measure_virtually(rig, ladder);
  ASSERT_EQ(materials.size(), 2U);
  EXPECT_EQ(materials[0].material, "part");
  EXPECT_EQ(materials[1].material, "soft");
  Rig numerical = rig;
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(materials[i].youngs_modulus_identified_pa, *rig.materials[i].youngs_modulus_pa);
    numerical.materials[i].youngs_modulus_pa = materials[i].youngs_modulus_numerical_pa;
  }
  const HexMesh& mesh = ladder.coarse.mesh;
  EXPECT_NEAR(compute_rung(numerical, mesh.requested_dx_m, mesh.kind, 1).modes.lambda_per_s2(0) /
                  ladder.limit.lambda_per_s2,
              1.0,
              1e-8);  // eigenvalues are found to 1e-10
}

TEST(VirtualMeasurement, IsReadBackAsWritten) {
  const Rig rig = stated_beam();
  LadderOptions options = small_ladder();
  options.coarse_element = ElementKind::Hex8e;
  const Material written = measure_virtually(rig, build_mesh_ladder(rig, options), kB_s).front();
  const std::filesystem::path path =
      std::filesystem::path(::testing::TempDir()) / "virtual_material.json";
  write_material(path, written);
  const Material read = read_material(path);
  std::filesystem::remove(path);
  EXPECT_EQ(material_to_json(read), material_to_json(written));
  EXPECT_EQ(read.numerical_element, "hex8e");
  EXPECT_EQ(read.provenance.options.at("measurement"), "virtual");
  EXPECT_FALSE(std::isfinite(read.frequency_sigma_hz));
}

TEST(VirtualMeasurement, RefusesWhatItCannotTell) {
  Rig rig = stated_beam();
  const MeshLadder ladder = build_mesh_ladder(rig, small_ladder());
  EXPECT_THROW((void)measure_virtually(rig, ladder, -1e-5), InputError);
  rig.materials.front().youngs_modulus_pa.reset();
  try {
    (void)measure_virtually(rig, ladder);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("materials.part states no youngs_modulus_pa"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace twang
