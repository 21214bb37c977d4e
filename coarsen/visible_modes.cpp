// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/visible_modes.hpp"

#include "rigs/observable.hpp"

#include <cmath>
#include <numeric>

namespace twang {
namespace {

constexpr double kFaint = 0.02;  // of what moves the observable most [-]

}  // namespace

std::vector<int> visible_modes(const Rig& rig, const MeshRung& rung) {
  std::vector<int> modes(static_cast<std::size_t>(rung.modes.count()));
  std::iota(modes.begin(), modes.end(), 0);
  if (!rig.observable) return modes;
  std::vector<Eigen::Vector3d> rest;
  for (const std::string& id : rig.observable->markers) {
    rest.push_back(rig.find_marker(id)->position);
  }
  const Eigen::Matrix3Xd gradient = observable_gradient(rig, rest);
  // A mode of amplitude 1 / sqrt(lambda) has unit energy: shapes are mass-orthonormal.
  Eigen::VectorXd seen = Eigen::VectorXd::Zero(rung.modes.count());
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (rig.find_marker(rig.observable->markers[i])->fixed) continue;
    const MeshPoint point = locate(rung.mesh, rest[i]);
    for (int mode = 0; mode < rung.modes.count(); ++mode) {
      seen[mode] += gradient.col(static_cast<Eigen::Index>(i))
                        .dot(interpolate(point, rung.modes.shapes.col(mode)));
    }
  }
  for (int mode = 0; mode < rung.modes.count(); ++mode) {
    seen[mode] = std::abs(seen[mode]) / std::sqrt(rung.modes.lambda_per_s2[mode]);
  }
  const double least = kFaint * seen.maxCoeff();
  std::erase_if(modes, [&](int mode) { return seen[mode] < least; });
  return modes;
}

}  // namespace twang
