// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/detail/visible_share.hpp"

#include "calibrate/simulated_observable.hpp"

#include <cmath>
#include <optional>

namespace twang::detail {
namespace {

/// Largest displacement of a node.
double peak_of(const Eigen::VectorXd& shape) {
  return Eigen::Map<const Eigen::Matrix3Xd>(shape.data(), 3, shape.size() / 3)
      .colwise()
      .norm()
      .maxCoeff();
}

/// The coordinate that "tip.x_mm" is: of a marker of the part, 0 to 2.
struct Coordinate {
  const Marker* marker = nullptr;
  int axis = 0;
};

std::optional<Coordinate> coordinate_of(const Rig& rig, const std::string& column) {
  for (const Marker& marker : rig.markers) {
    if (marker.fixed || !column.starts_with(marker.id + ".")) continue;
    const std::string rest = column.substr(marker.id.size() + 1);
    if (rest.size() < 2 || rest[1] != '_') continue;
    const std::size_t axis = std::string("xyz").find(rest[0]);
    if (axis != std::string::npos) return Coordinate{&marker, static_cast<int>(axis)};
  }
  return {};
}

}  // namespace

Eigen::VectorXd visible_shares(const Rig& rig,
                               const MeshRung& rung,
                               const std::vector<std::string>& columns) {
  const Eigenmodes& modes = rung.modes;
  Eigen::VectorXd square = Eigen::VectorXd::Zero(modes.count());
  const SimulatedObservable observable(rig, rung);
  for (const std::string& column : columns) {
    const std::optional<Coordinate> coordinate = coordinate_of(rig, column);
    const bool is_observable = rig.observable && column.starts_with("observable_");
    const MeshPoint point =
        coordinate ? locate(rung.mesh, coordinate->marker->position) : MeshPoint{};
    for (int mode = 0; mode < modes.count(); ++mode) {
      const Eigen::VectorXd shape = modes.shapes.col(mode);
      double moved = 0.0;
      if (is_observable) {
        moved = observable.linearized(shape);
      } else if (coordinate) {
        moved = interpolate(point, shape)[coordinate->axis];
      } else {
        moved = peak_of(shape);
      }
      square[mode] += moved * moved / modes.lambda_per_s2[mode];
    }
  }
  const double most = square.size() == 0 ? 0.0 : square.maxCoeff();
  if (!(most > 0.0)) return Eigen::VectorXd::Ones(modes.count());
  return (square / most).cwiseSqrt();
}

}  // namespace twang::detail
