// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/offset_faces.hpp"
#include "coarsen/fit_material.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/error.hpp"
#include "tests/coarsen/rigs_of_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace twang {
namespace {

using Eigen::Vector3d;
using test::mm;

TEST(OutwardGrowth, MakesABoxLongerByTheGrowthInEachDimension) {
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20}) {
    HexMesh mesh = mesh_part(test::beam(mm(80, 10, 2), 0.3, 1000.0), 2e-3, kind);
    mesh.nodes += 1e-3 * outward_growth(mesh);
    EXPECT_NEAR(mesh.volume(), 81e-3 * 11e-3 * 3e-3, 1e-18);  // round-off of 2.7e-6
    EXPECT_NEAR(mesh.nodes.row(0).minCoeff(), -0.5e-3, 1e-12);
    EXPECT_NEAR(mesh.nodes.row(2).maxCoeff(), 2.5e-3, 1e-12);
  }
}

TEST(OutwardGrowth, MovesEveryFaceOfAnLOutwards) {
  // Where leg and arm meet, the faces move into the part's own volume: what counts is the union.
  const double t = 0.2e-3;
  const double depth = 24e-3 + t;
  const double plate = (60e-3 + t) * (3e-3 + t);
  const double leg = (1.5e-3 + t) * (16.5e-3 - t);
  const double arm = (39e-3 + t) * (7.5e-3 + t);
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20}) {
    HexMesh mesh = mesh_part(test::l_rig(), 1.5e-3, kind);
    mesh.nodes += t * outward_growth(mesh);
    EXPECT_NEAR(mesh.volume() / (depth * (plate + leg + arm)), 1.0, 1e-9);  // round-off
  }
}

TEST(ModulusSensitivities, OfASlenderStripAreThoseOfTheBeamFormula) {
  // lambda = (1.8751 / L)^4 E h² / (12 rho), all dimensions growing alike.
  const double L = 80e-3;
  const double h = 2e-3;
  const Rig rig = test::beam({L, 10e-3, h}, 0.0, 1180.0);
  const ModulusSensitivities s = modulus_sensitivities(rig, 2e-3);
  const double formula = -2.0 / h + 4.0 / L;
  // Shear takes 0.3 % of a strip 40 times longer than thick; one hex20 through the thickness 1 %.
  EXPECT_NEAR(s.dimension_per_m, formula, 0.01 * std::abs(formula));
  EXPECT_NEAR(s.poissons_ratio, 0.0, 0.01);  // bending of a beam free of nu at nu = 0
  EXPECT_EQ(s.density, 1.0);
}

TEST(ModulusSensitivities, EqualDifferencesOfNewlySolvedModes) {
  // Another part, 50 um larger all round, meshed and solved anew; nu and rho likewise.
  const auto lambda_of = [](const Rig& rig) {
    const HexMesh mesh = mesh_part(rig, 2.5e-3, ElementKind::Hex20);
    ElasticBody body(mesh, elastic_materials(rig, mesh), ConstitutiveModel::Linear);
    for (const PointMass& weight : rig.masses) {
      body.add_point_mass(locate(mesh, weight.at), weight.mass_kg);
    }
    EigenmodeOptions options;
    options.count = 1;
    return compute_eigenmodes(body, clamped_nodes(mesh, rig), options).lambda_per_s2(0);
  };
  const auto rig_with = [](double growth, double nu, double rho) {
    Rig rig = test::beam(mm(40, 10, 5) + Vector3d::Constant(growth), nu, rho);
    rig.masses.push_back({mm(40, 5, 2.5) + Vector3d(growth, growth / 2, growth / 2), 1e-3});
    return rig;
  };
  const ModulusSensitivities s = modulus_sensitivities(rig_with(0.0, 0.4, 1000.0), 2.5e-3);
  const auto slope = [](double below, double above, double step) {
    return -std::log(above / below) / (2.0 * step);
  };
  const double t = 5e-5;
  // Central differences with these steps err by their square, below 1e-3.
  const double by_size =
      slope(lambda_of(rig_with(-t, 0.4, 1000.0)), lambda_of(rig_with(t, 0.4, 1000.0)), t);
  EXPECT_NEAR(s.dimension_per_m, by_size, 2e-3 * std::abs(by_size));
  const double by_nu = slope(
      lambda_of(rig_with(0.0, 0.395, 1000.0)), lambda_of(rig_with(0.0, 0.405, 1000.0)), 0.005);
  EXPECT_NEAR(s.poissons_ratio, by_nu, 5e-3 * std::abs(by_nu));
  const double by_density = slope(lambda_of(rig_with(0.0, 0.4, 1000.0 * std::exp(-0.01))),
                                  lambda_of(rig_with(0.0, 0.4, 1000.0 * std::exp(0.01))),
                                  0.01);
  EXPECT_NEAR(s.density, by_density, 1e-3);
  EXPECT_LT(s.density, 0.9);  // the weight is half of the beam's 2 g
}

TEST(ModulusSensitivities, StayFiniteNextToIncompressibility) {
  const ModulusSensitivities s =
      modulus_sensitivities(test::beam(mm(100, 30, 30), 0.499, 1070), 0.03);
  EXPECT_TRUE(std::isfinite(s.poissons_ratio));
  EXPECT_LT(s.dimension_per_m, 0.0);
}

TEST(ElasticMaterials, TakeTheStatedModulusElseTheGivenOne) {
  Rig rig = test::beam(mm(10, 10, 10), 0.3, 1200.0);
  const HexMesh mesh = mesh_part(rig, 5e-3, ElementKind::Hex8);
  EXPECT_EQ(elastic_materials(rig, mesh).front().youngs_modulus_pa, 1.0);
  EXPECT_EQ(elastic_materials(rig, mesh, 7e8).front().youngs_modulus_pa, 7e8);
  rig.materials.front().youngs_modulus_pa = 2e9;
  const ElasticMaterial material = elastic_materials(rig, mesh, 7e8).front();
  EXPECT_EQ(material.youngs_modulus_pa, 2e9);
  EXPECT_EQ(material.poissons_ratio, 0.3);
  EXPECT_EQ(material.density_kg_m3, 1200.0);
  rig.materials.clear();
  EXPECT_THROW((void)elastic_materials(rig, mesh), InputError);
}

}  // namespace
}  // namespace twang
