// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/element_kernels.hpp"

#include "fem/detail/element_geometry.hpp"
#include "tests/fem/distorted_mesh.hpp"
#include "tests/support/finite_differences.hpp"

#include <gtest/gtest.h>

namespace twang {
namespace {

using Eigen::VectorXd;

TEST(ElementKernels, GiveTheSameOnEveryInstructionSet) {
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) {
    GTEST_SKIP() << "this machine has no AVX2";
  }
  const std::vector<double> mu = {1.0, 2.0, 0.5, 3.0};
  const std::vector<double> lambda = {4.0, 0.0, 1.5, 2.0};
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20, ElementKind::Hex8e}) {
    const int nodes = nodes_per_element(kind);
    const VectorXd u = test::random_vector(3 * nodes * kLanes, 0.05, 1);
    const VectorXd w = test::random_vector(3 * nodes * kLanes, 1.0, 2);
    for (const double distortion : {0.0, 0.1}) {
      const ElementGeometry geometry(test::distorted_mesh(kind, distortion));
      const ElementBatch batch{geometry.batch(1), mu.data(), lambda.data(), u.data(), w.data()};
      for (const ConstitutiveModel model : {ConstitutiveModel::NeoHookean,
                                            ConstitutiveModel::SaintVenantKirchhoff,
                                            ConstitutiveModel::Linear}) {
        const ElementKernels baseline = kernels_baseline::kernels(kind, model);
        const ElementKernels v3 = kernels_x86_64_v3::kernels(kind, model);
        const auto expect_same = [&](ElementKernels::Kernel a, ElementKernels::Kernel b, int size) {
          VectorXd from_a(size * kLanes);
          VectorXd from_b(size * kLanes);
          a(batch, from_a.data());
          b(batch, from_b.data());
          // Fused multiply-adds round differently.
          EXPECT_LT((from_a - from_b).norm(), 1e-13 * from_a.norm());
          EXPECT_GT(from_a.norm(), 0.0);
        };
        expect_same(baseline.energy, v3.energy, 1);
        expect_same(baseline.force, v3.force, 3 * nodes);
        expect_same(baseline.product, v3.product, 3 * nodes);
        expect_same(baseline.tangent, v3.tangent, 9 * nodes * (nodes + 1) / 2);
      }
    }
  }
}

}  // namespace
}  // namespace twang
