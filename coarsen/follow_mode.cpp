// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/follow_mode.hpp"

#include "coarsen/detail/ladder_steps.hpp"
#include "coarsen/detail/sample_shapes.hpp"
#include "core/dense_algebra.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace twang {
namespace {

/// Modes whose frequencies follow each other this closely may be turned into one another by a mesh.
constexpr double kSameFrequency = 0.03;  // [-]
constexpr Eigen::Index kMostPoints = 2000;

struct Family {
  int first = 0;
  int size = 1;
};

Family family_of(const Eigenmodes& modes, int index) {
  const auto near = [&](int a, int b) {
    const double fa = modes.natural_frequency_hz(a);
    const double fb = modes.natural_frequency_hz(b);
    return std::abs(fb - fa) <= kSameFrequency * std::max(fa, fb);
  };
  Family family{index, 1};
  while (family.first > 0 && near(family.first - 1, family.first)) --family.first;
  int last = index;
  while (last + 1 < modes.count() && near(last, last + 1)) ++last;
  family.size = last - family.first + 1;
  return family;
}

/// All shapes of a rung at points, (3 n x modes); on a mesh from a file point by point.
Eigen::MatrixXd shapes_at(const MeshRung& rung, const Eigen::Matrix3Xd& points) {
  const bool voxels = (rung.mesh.actual_dx_m.array() > 0.0).all();
  if (voxels) return sample_fields(rung.mesh, rung.modes.shapes, points);
  Eigen::MatrixXd sampled(3 * points.cols(), rung.modes.count());
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const MeshPoint point = locate(rung.mesh, points.col(i));
    for (int mode = 0; mode < rung.modes.count(); ++mode) {
      sampled.block<3, 1>(3 * i, mode) = interpolate(point, rung.modes.shapes.col(mode));
    }
  }
  return sampled;
}

}  // namespace

FollowedMode follow_mode(const MeshRung& rung, int index, const MeshRung& other) {
  if (&rung == &other) return {index, 1.0};
  const Eigen::Index num_nodes = rung.mesh.num_nodes();
  const Eigen::Index stride = (num_nodes + kMostPoints - 1) / kMostPoints;
  const Eigen::Index num_points = (num_nodes + stride - 1) / stride;
  const Family family = family_of(rung.modes, index);
  Eigen::Matrix3Xd points(3, num_points);
  Eigen::MatrixXd shapes(3 * num_points, family.size);
  for (Eigen::Index i = 0; i < num_points; ++i) {
    points.col(i) = rung.mesh.nodes.col(i * stride);
    shapes.middleRows(3 * i, 3) =
        rung.modes.shapes.block(3 * i * stride, family.first, 3, family.size);
  }
  const Eigen::MatrixXd Q = orthonormal_basis(shapes);
  const Eigen::MatrixXd sampled = shapes_at(other, points);
  const Eigen::VectorXd affinity =
      ((Q.transpose() * sampled).colwise().norm().array() /
       sampled.colwise().norm().array().max(std::numeric_limits<double>::min()))
          .transpose();
  Eigen::Index best = 0;
  const double closest = affinity.maxCoeff(&best);
  const Family found = family_of(other.modes, static_cast<int>(best));
  return {found.first + std::min(index - family.first, found.size - 1), closest};
}

RichardsonLimit limit_of_mode(const MeshLadder& ladder, int mode) {
  std::vector<double> lambdas;
  for (const MeshRung& rung : ladder.reference) {
    const MeshRung& finest = ladder.reference.back();
    const int here = &rung == &finest ? mode : follow_mode(finest, mode, rung).mode;
    lambdas.push_back(rung.modes.lambda_per_s2[here]);
  }
  return limit_of(ladder.reference, lambdas);
}

}  // namespace twang
