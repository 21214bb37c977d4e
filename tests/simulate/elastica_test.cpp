// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/static_solve.hpp"
#include "tests/simulate/box_body.hpp"

#include <gtest/gtest.h>

namespace twang {
namespace {

struct Elastica {
  double load;  // P L² / E I [-]
  double sag;   // w / L
  double draw;  // u / L, towards the clamp
};

class ElasticaTest : public testing::TestWithParam<Elastica> {};

TEST_P(ElasticaTest, SlenderCantileverFollowsTheElliptcIntegrals) {
  const double E = 1e9;
  const Eigen::Vector3d size(0.1, 0.002, 0.001);
  ElasticMaterial material;
  material.youngs_modulus_pa = E;
  material.poissons_ratio = 0.0;
  const ElasticBody body(test::box_mesh(ElementKind::Hex20, {40, 1, 1}, size), {material});
  const double inertia = size.y() * std::pow(size.z(), 3) / 12.0;
  const MeshPoint end = locate(body.mesh(), {size.x(), 0.5 * size.y(), 0.5 * size.z()});
  const double P = GetParam().load * E * inertia / (size.x() * size.x());
  StaticLoad load;
  load.force = nodal_force(body.mesh(), end, {0.0, 0.0, -P});
  const StaticResult result = solve_static(body, test::nodes_at(body.mesh(), 0, 0.0), load);
  ASSERT_TRUE(result.usable()) << result.message;
  const Eigen::Vector3d tip = interpolate(end, result.u) / size.x();
  // L / thickness = 100: shear and stretch add below 1e-4, the mesh about 1e-3.
  EXPECT_NEAR(-tip.z(), GetParam().sag, 5e-3 * GetParam().sag);
  EXPECT_NEAR(-tip.x(), GetParam().draw, 5e-3 * GetParam().draw);
  RecordProperty("newton_iterations", result.newton_iterations);
  RecordProperty("load_steps", result.load_steps);
}

// Exact solutions of E I theta'' = -P cos(theta) by elliptic integrals.
INSTANTIATE_TEST_SUITE_P(Loads,
                         ElasticaTest,
                         testing::Values(Elastica{1.0, 0.30172, 0.05643},
                                         Elastica{2.0, 0.49346, 0.16064},
                                         Elastica{5.0, 0.71379, 0.38763},
                                         Elastica{10.0, 0.81061, 0.55500}));

}  // namespace
}  // namespace twang
