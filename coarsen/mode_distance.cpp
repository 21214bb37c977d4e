// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/sample_shapes.hpp"
#include "coarsen/detail/surface_distance.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/dense_algebra.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <vector>

namespace twang {
namespace {

/// Modes whose frequencies follow each other this closely are compared as one subspace: a mesh may
/// turn them into one another at will. As wide as a frequency may err that is called accurate [-].
constexpr double kNearEqual = 0.05;
/// Coarse modes beyond the compared ones that may be partners, for shapes that change places.
constexpr int kSpareModes = 6;
/// Peak deflection at which the Hausdorff distance is taken, over the part's largest dimension [-].
constexpr double kDeflection = 0.1;

/// The outside of a mesh as triangles over its corner nodes.
struct Surface {
  std::vector<int> nodes;           ///< of the mesh
  std::vector<Triangle> triangles;  ///< indices into `nodes`
  Eigen::Matrix3Xd positions;       ///< (3 x nodes) [m]
};

Surface surface_of(const HexMesh& mesh) {
  Surface surface;
  std::vector<int> index(static_cast<std::size_t>(mesh.num_nodes()), -1);
  for (const std::array<int, 4>& face : surface_faces(mesh)) {
    std::array<int, 4> corner{};
    for (std::size_t i = 0; i < 4; ++i) {
      int& known = index[static_cast<std::size_t>(face[i])];
      if (known < 0) {
        known = static_cast<int>(surface.nodes.size());
        surface.nodes.push_back(face[i]);
      }
      corner[i] = known;
    }
    surface.triangles.push_back({corner[0], corner[1], corner[2]});
    surface.triangles.push_back({corner[0], corner[2], corner[3]});
  }
  surface.positions.resize(3, static_cast<Eigen::Index>(surface.nodes.size()));
  for (std::size_t i = 0; i < surface.nodes.size(); ++i) {
    surface.positions.col(static_cast<Eigen::Index>(i)) = mesh.nodes.col(surface.nodes[i]);
  }
  return surface;
}

/// The first `count` shapes of `rung` at its own `nodes`, (3 nodes x count).
Eigen::MatrixXd shapes_at_nodes(const MeshRung& rung, const std::vector<int>& nodes, int count) {
  Eigen::MatrixXd samples(3 * static_cast<Eigen::Index>(nodes.size()), count);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    samples.middleRows(3 * static_cast<Eigen::Index>(i), 3) =
        rung.modes.shapes.block(3 * nodes[i], 0, 3, count);
  }
  return samples;
}

/// For each mode the first of its group of near-equal frequencies.
std::vector<int> group_by_frequency(const Eigenmodes& modes, int count) {
  std::vector<int> first(static_cast<std::size_t>(count), 0);
  for (int i = 1; i < count; ++i) {
    const double below = modes.natural_frequency_hz(i - 1);
    const double here = modes.natural_frequency_hz(i);
    const bool near = here - below <= kNearEqual * here;
    first[static_cast<std::size_t>(i)] = near ? first[static_cast<std::size_t>(i - 1)] : i;
  }
  return first;
}

/// Coarse modes that together stand for a group of fine ones: as many as the group has, those that
/// lie most nearly in its span, and whatever shares their frequencies.
std::vector<int> partners(const Eigen::MatrixXd& fine_group,
                          const Eigen::MatrixXd& coarse,
                          const std::vector<int>& coarse_first) {
  const Eigen::MatrixXd Q = orthonormal_basis(fine_group);
  const Eigen::VectorXd affinity =
      ((Q.transpose() * coarse).colwise().norm().array() /
       coarse.colwise().norm().array().max(std::numeric_limits<double>::min()))
          .transpose();
  std::vector<int> order(static_cast<std::size_t>(coarse.cols()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(
      order.begin(), order.end(), [&](int a, int b) { return affinity(a) > affinity(b); });
  order.resize(std::min(order.size(), static_cast<std::size_t>(fine_group.cols())));

  std::set<int> groups;
  for (const int mode : order) groups.insert(coarse_first[static_cast<std::size_t>(mode)]);
  std::vector<int> chosen;
  for (int mode = 0; mode < coarse.cols(); ++mode) {
    if (groups.count(coarse_first[static_cast<std::size_t>(mode)]) > 0) chosen.push_back(mode);
  }
  return chosen;
}

double peak_of(const Eigen::VectorXd& field) {
  return Eigen::Map<const Eigen::Matrix3Xd>(field.data(), 3, field.size() / 3)
      .colwise()
      .norm()
      .maxCoeff();
}

/// The field in the span of `basis` nearest to `shape`, at the same peak.
Eigen::VectorXd nearest_in_span(const Eigen::MatrixXd& basis, const Eigen::VectorXd& shape) {
  const Eigen::VectorXd nearest = basis * solve_least_squares(basis, shape).x.col(0);
  const double peak = peak_of(nearest);
  return peak > 0.0 ? Eigen::VectorXd(nearest * (peak_of(shape) / peak)) : nearest;
}

Eigen::Matrix3Xd deflected(const Surface& surface, const Eigen::VectorXd& field, double scale) {
  return surface.positions +
         scale * Eigen::Map<const Eigen::Matrix3Xd>(field.data(), 3, field.size() / 3);
}

}  // namespace

ModeComparison compare_modes(const MeshRung& fine, const MeshRung& coarse, int num_modes) {
  const Surface surface = surface_of(fine.mesh);
  const int num_fine = std::min(fine.modes.count(), num_modes + kSpareModes);
  const int num_coarse = std::min(coarse.modes.count(), num_modes + kSpareModes);
  const Eigen::MatrixXd fine_shapes = shapes_at_nodes(fine, surface.nodes, num_fine);
  const Eigen::MatrixXd coarse_shapes =
      sample_fields(coarse.mesh, coarse.modes.shapes.leftCols(num_coarse), surface.positions);
  const std::vector<int> fine_first = group_by_frequency(fine.modes, num_fine);
  const std::vector<int> coarse_first = group_by_frequency(coarse.modes, num_coarse);
  const double deflection =
      kDeflection *
      (surface.positions.rowwise().maxCoeff() - surface.positions.rowwise().minCoeff()).maxCoeff();

  ModeComparison comparison;
  for (int mode = 0; mode < std::min(num_modes, num_fine); ++mode) {
    const int first = fine_first[static_cast<std::size_t>(mode)];
    const auto size = std::count(fine_first.begin(), fine_first.end(), first);
    const std::vector<int> basis =
        partners(fine_shapes.middleCols(first, size), coarse_shapes, coarse_first);
    const Eigen::VectorXd shape = fine_shapes.col(mode);
    const Eigen::VectorXd partner = nearest_in_span(coarse_shapes(Eigen::all, basis), shape);
    const double peak = peak_of(shape);
    const double scale = deflection / peak;
    comparison.difference_by_mode.push_back(peak_of(shape - partner) / peak);
    comparison.hausdorff_by_mode.push_back(hausdorff_distance(deflected(surface, shape, scale),
                                                              deflected(surface, partner, scale),
                                                              surface.triangles) /
                                           deflection);
  }
  for (const double d : comparison.difference_by_mode) {
    comparison.max_difference = std::max(comparison.max_difference, d);
  }
  for (const double h : comparison.hausdorff_by_mode) {
    comparison.hausdorff = std::max(comparison.hausdorff, h);
  }
  return comparison;
}

}  // namespace twang
