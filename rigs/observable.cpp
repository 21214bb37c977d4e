// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/observable.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <cmath>

namespace twang {
namespace {

/// Rig directions that point right and up in the image.
struct ImageAxes {
  Eigen::Vector3d right;
  Eigen::Vector3d up;

  [[nodiscard]] Eigen::Vector2d project(const Eigen::Vector3d& vector) const {
    return {right.dot(vector), up.dot(vector)};
  }
};

ImageAxes axes_of(const Rig& rig) {
  const Camera camera = rig.camera.value_or(Camera{});
  return {camera.image_right, -camera.image_down};
}

const ObservableDefinition& observable_of(const Rig& rig, std::size_t num_positions) {
  if (!rig.observable) {
    throw InputError(fmt::format("rig '{}' has no [observable], must have one", rig.name));
  }
  const std::size_t expected = rig.observable->kind == ObservableKind::Angle ? 2 : 1;
  if (num_positions != expected || rig.observable->markers.size() != expected) {
    throw InputError(
        fmt::format("the observable of rig '{}' is given {} positions for {} markers, must be {}",
                    rig.name,
                    num_positions,
                    rig.observable->markers.size(),
                    expected));
  }
  return *rig.observable;
}

}  // namespace

std::string observable_column(ObservableKind kind) { return "observable_" + observable_unit(kind); }

std::string observable_unit(ObservableKind kind) {
  return kind == ObservableKind::Angle ? "rad" : "mm";
}

double evaluate_observable(const Rig& rig,
                           const std::vector<Eigen::Vector3d>& positions,
                           const std::vector<Eigen::Vector3d>& rest) {
  const ObservableDefinition& observable = observable_of(rig, positions.size());
  if (rest.size() != positions.size()) {
    throw InputError(fmt::format(
        "the observable is given {} rest positions, must be {}", rest.size(), positions.size()));
  }
  if (observable.kind == ObservableKind::Displacement) {
    return (positions[0] - rest[0]).dot(observable.direction) / observable.direction.norm();
  }
  const ImageAxes axes = axes_of(rig);
  const Eigen::Vector2d before = axes.project(rest[1] - rest[0]);
  const Eigen::Vector2d now = axes.project(positions[1] - positions[0]);
  const double cross = before.x() * now.y() - before.y() * now.x();
  const double turn = std::atan2(cross, before.dot(now));
  return turn <= -kPi ? kPi : turn;
}

Eigen::Matrix3Xd observable_gradient(const Rig& rig,
                                     const std::vector<Eigen::Vector3d>& positions) {
  const ObservableDefinition& observable = observable_of(rig, positions.size());
  if (observable.kind == ObservableKind::Displacement) return observable.direction.normalized();
  const ImageAxes axes = axes_of(rig);
  const Eigen::Vector2d line = axes.project(positions[1] - positions[0]);
  Eigen::Matrix3Xd gradient(3, 2);
  gradient.col(1) = (line.x() * axes.up - line.y() * axes.right) / line.squaredNorm();
  gradient.col(0) = -gradient.col(1);
  return gradient;
}

void unwrap(std::vector<double>& angles) {
  double last = kNaN;
  for (double& angle : angles) {
    if (!std::isfinite(angle)) continue;
    if (!std::isnan(last)) angle -= kTwoPi * std::round((angle - last) / kTwoPi);
    last = angle;
  }
}

}  // namespace twang
