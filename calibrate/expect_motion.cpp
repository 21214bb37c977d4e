// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/check_rig.hpp"
#include "calibrate/simulated_observable.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/constants.hpp"
#include "core/error.hpp"
#include "fem/hex_mesh.hpp"
#include "fem/thinnest_wall.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace twang {
namespace {

constexpr int kModes = 8;
constexpr int kRigidModes = 6;
constexpr int kHalvings = 4;  // until every solid and clamp is caught

double smallest_edge_m(const Rig& rig) {
  const Box all = rig.bounding_box();
  return std::min(thinnest_wall_m(rig), (all.max - all.min).minCoeff());
}

/// The rig with the reported modulus taken for each that is not stated; whether all are known then.
bool take_reported_moduli(Rig& rig, double& modulus_pa) {
  bool all_known = true;
  for (RigMaterial& material : rig.materials) {
    const bool used = std::any_of(rig.parts.begin(), rig.parts.end(), [&](const PartSolid& solid) {
      return solid.material == material.name;
    });
    if (!material.youngs_modulus_pa)
      material.youngs_modulus_pa = material.reported_youngs_modulus_pa;
    if (!used) continue;
    if (material.youngs_modulus_pa) {
      modulus_pa = *material.youngs_modulus_pa;
    } else {
      all_known = false;
    }
  }
  return all_known;
}

/// Cells as large as the smallest edge; halved until every solid and clamp is caught, doubled while
/// the mesh has too many unknowns.
double moderate_dx(const Rig& rig, const CheckOptions& options) {
  double dx = smallest_edge_m(rig);
  for (int halvings = 0;; ++halvings) {
    try {
      const HexMesh mesh = mesh_part(rig, dx, ElementKind::Hex20);
      if (!rig.clamps.empty()) std::ignore = clamped_nodes(mesh, rig);
      if (mesh.num_dofs() <= options.max_dofs) return dx;
      break;
    } catch (const InputError&) {
      if (halvings == kHalvings) throw;
      dx /= 2.0;
    }
  }
  for (;;) {
    dx *= 2.0;
    if (mesh_part(rig, dx, ElementKind::Hex20).num_dofs() <= options.max_dofs) return dx;
  }
}

/// The shape in which the release holds the part, from the modes' responses to a force there:
///
///     u = sum_k phi_k (phi_k . F) / lambda_k,
///
/// scaled to the release's displacement along itself if it is one.
Eigen::VectorXd held_shape(const Rig& rig, const MeshRung& rung) {
  const Release& release = *rig.release;
  const MeshPoint point = locate(rung.mesh, release.at);
  const Eigen::Vector3d pull = release.force ? *release.force : *release.displacement;
  Eigen::VectorXd u = Eigen::VectorXd::Zero(rung.mesh.num_dofs());
  for (int k = 0; k < rung.modes.count(); ++k) {
    if (!(rung.modes.lambda_per_s2[k] > 0.0)) continue;
    const Eigen::VectorXd shape = rung.modes.shapes.col(k);
    u += shape * (interpolate(point, shape).dot(pull) / rung.modes.lambda_per_s2[k]);
  }
  if (release.force) return u;
  const double along = interpolate(point, u).dot(pull) / pull.squaredNorm();
  return along > 0.0 ? Eigen::VectorXd(u / along) : Eigen::VectorXd();
}

/// How the observable's change compares with what it would be if all of the mode's motion at its
/// markers were seen.
double observable_share(const Rig& rig, const MeshRung& rung, int mode) {
  const SimulatedObservable observable(rig, rung);
  double seen = 0.0;
  double all = 0.0;
  for (const int index : mode_cluster(rung.modes, mode)) {
    const Eigen::VectorXd shape = rung.modes.shapes.col(index);
    seen += std::pow(observable.linearized(shape), 2);
    double largest = 0.0;
    for (const std::string& id : rig.observable->markers) {
      const Marker& marker = *rig.find_marker(id);
      if (marker.fixed) continue;
      largest = std::max(largest, interpolate(locate(rung.mesh, marker.position), shape).norm());
    }
    if (rig.observable->kind == ObservableKind::Angle) {
      const Eigen::Vector3d line = rig.find_marker(rig.observable->markers[1])->position -
                                   rig.find_marker(rig.observable->markers[0])->position;
      largest /= std::max(line.norm(), 1e-9);
    }
    all += largest * largest;
  }
  return all > 0.0 ? std::min(1.0, std::sqrt(seen / all)) : 0.0;
}

}  // namespace

ExpectedMotion expect_motion(const Rig& rig, const CheckOptions& options) {
  ExpectedMotion motion;
  if (rig.parts.empty()) {
    motion.unknown_because = "The rig has no [[part]], so its motion is not predicted";
    return motion;
  }
  Rig known = rig;
  motion.modulus_known = take_reported_moduli(known, motion.modulus_pa);
  MeshRung rung;
  try {
    const double dx_m = moderate_dx(known, options);
    motion.thin_parts_missed = dx_m > smallest_edge_m(known);
    rung = compute_rung(known, dx_m, ElementKind::Hex20, kModes + kRigidModes, options.progress);
  } catch (const Cancelled&) {
    throw;
  } catch (const std::exception& error) {
    motion.unknown_because = fmt::format("The motion is not predicted: {}", error.what());
    return motion;
  }
  int first = 0;
  while (first < rung.modes.count() && !(rung.modes.lambda_per_s2[first] > 0.0)) ++first;
  for (int k = first; k < rung.modes.count(); ++k) {
    motion.frequency_hz.push_back(rung.modes.natural_frequency_hz(k));
  }
  if (motion.frequency_hz.empty()) return motion;
  for (int k = first; rig.observable && k < rung.modes.count(); ++k) {
    motion.observable_share.push_back(observable_share(known, rung, k));
  }
  const bool shape_known =
      rig.release && (rig.release->displacement || (rig.release->force && motion.modulus_known));
  if (!shape_known) return motion;
  const Eigen::VectorXd held = held_shape(known, rung);
  if (held.size() == 0) return motion;
  for (const Marker& marker : rig.markers) {
    motion.amplitude_m.push_back(marker.fixed
                                     ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                                     : interpolate(locate(rung.mesh, marker.position), held));
  }
  return motion;
}

}  // namespace twang
