// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/coarse_grid.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

namespace twang {
namespace {

constexpr int kThreadedFineNodes = 20'000;

/// Where the coarse cells begin along each axis, 0 or 1 cell before the first: whatever makes the
/// fewest of them.
Eigen::Vector3i choose_offset(const CellGrid& fine) {
  Eigen::Vector3i best = Eigen::Vector3i::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    int fewest = std::numeric_limits<int>::max();
    const Eigen::Vector3i so_far = best;
    for (int offset = 0; offset < 2; ++offset) {
      Eigen::Vector3i trial = so_far;
      trial[axis] = offset;
      Eigen::Matrix3Xi halved = fine.cells().colwise() + trial;
      halved.row(axis) /= 2;
      const int count = CellGrid(halved).num_cells();
      if (count < fewest) best = trial;
      fewest = std::min(fewest, count);
    }
  }
  return best;
}

/// Trilinear functions of a coarse cell at the corners of one of its eight parts, (part's corner x
/// coarse corner).
Eigen::Matrix<double, 8, 8> interpolation(int part) {
  Eigen::Matrix<double, 8, 8> P;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d at = 0.5 * (corner_offset(part) + corner_offset(corner)).cast<double>();
    for (int coarse = 0; coarse < 8; ++coarse) {
      const Eigen::Array3d towards = corner_offset(coarse).cast<double>();
      P(corner, coarse) = (towards * at.array() + (1.0 - towards) * (1.0 - at.array())).prod();
    }
  }
  return P;
}

}  // namespace

int TypedGrid::num_free() const {
  return static_cast<int>(std::count(held.begin(), held.end(), 0));
}

void zero_held(std::uint32_t held, Eigen::MatrixXd& matrix) {
  for (int i = 0; i < 24; ++i) {
    if ((held >> i & 1U) == 0) continue;
    matrix.row(i).setZero();
    matrix.col(i).setZero();
  }
}

std::uint32_t held_mask(const std::vector<char>& held,
                        int num_nodes,
                        const Eigen::Matrix<int, 8, 1>& nodes) {
  std::uint32_t mask = 0;
  for (int a = 0; a < 3; ++a) {
    for (int n = 0; n < 8; ++n) {
      const auto dof = static_cast<std::size_t>(a * num_nodes + nodes[n]);
      if (held[dof] != 0) mask |= 1U << (8 * a + n);
    }
  }
  return mask;
}

CoarseGrid::CoarseGrid(const TypedGrid& fine) {
  const Eigen::Vector3i offset = choose_offset(fine.grid);
  const Eigen::Matrix3Xi shifted = fine.grid.cells().colwise() + offset;
  cells.grid = CellGrid(shifted / 2);
  const CellGrid& grid = cells.grid;
  const int num_fine = fine.grid.num_nodes();
  const int num_nodes = grid.num_nodes();

  std::vector<int> from_fine;
  parents_start = Eigen::ArrayXi::Zero(num_fine + 1);
  children_start = Eigen::ArrayXi::Zero(num_nodes + 1);
  cells.held.assign(static_cast<std::size_t>(3 * num_nodes), 0);
  std::vector<char> has_free(static_cast<std::size_t>(3 * num_nodes), 0);
  for (int n = 0; n < num_fine; ++n) {
    const Eigen::Vector3i at = fine.grid.nodes().col(n) + offset;
    const int odd = (at[0] & 1) | (at[1] & 1) << 1 | (at[2] & 1) << 2;
    for (int corner = 0; corner < 8; ++corner) {
      if ((corner & ~odd) != 0) continue;
      const int parent = grid.find_node(at / 2 + corner_offset(corner));
      from_fine.push_back(parent);
      ++children_start[parent + 1];
      for (int a = 0; a < 3; ++a) {
        const bool held = fine.held[static_cast<std::size_t>(a * num_fine + n)] != 0;
        const auto dof = static_cast<std::size_t>(a * num_nodes + parent);
        if (!held) has_free[dof] = 1;
        if (held && odd == 0) cells.held[dof] = 1;
      }
    }
    parents_start[n + 1] = static_cast<int>(from_fine.size());
  }
  for (std::size_t dof = 0; dof < has_free.size(); ++dof) {
    if (has_free[dof] == 0) cells.held[dof] = 1;
  }
  parents =
      Eigen::Map<Eigen::ArrayXi>(from_fine.data(), static_cast<Eigen::Index>(from_fine.size()));
  for (int n = 0; n < num_nodes; ++n) children_start[n + 1] += children_start[n];
  children.resize(parents.size());
  Eigen::ArrayXi next = children_start;
  for (int n = 0; n < num_fine; ++n) {
    for (int i = parents_start[n]; i < parents_start[n + 1]; ++i) children[next[parents[i]]++] = n;
  }

  Eigen::Array<int, 8, Eigen::Dynamic> parts(8, grid.num_cells());
  parts.setConstant(-1);
  for (int c = 0; c < fine.grid.num_cells(); ++c) {
    const Eigen::Vector3i at = shifted.col(c);
    const int part = (at[0] & 1) | (at[1] & 1) << 1 | (at[2] & 1) << 2;
    parts(part, grid.find_cell(at / 2)) = fine.type[c];
  }
  const auto nodes = grid.nodes_of_cells();
  std::map<std::pair<std::array<int, 8>, std::uint32_t>, int> known;
  cells.type.resize(grid.num_cells());
  for (int c = 0; c < grid.num_cells(); ++c) {
    std::array<int, 8> own;
    for (int part = 0; part < 8; ++part) own[static_cast<std::size_t>(part)] = parts(part, c);
    const std::uint32_t mask = held_mask(cells.held, num_nodes, nodes.col(c));
    const auto [at, added] = known.try_emplace({own, mask}, static_cast<int>(parts_of_type.size()));
    if (added) {
      parts_of_type.push_back(own);
      cells.held_of_type.push_back(mask);
    }
    cells.type[c] = at->second;
  }
  cells.num_types = static_cast<int>(parts_of_type.size());
}

void CoarseGrid::prolong(const TypedGrid& fine, const float* coarse, float* result) const {
  const int num_fine = fine.grid.num_nodes();
  const int num_coarse = cells.grid.num_nodes();
#pragma omp parallel for schedule(static) if (num_fine > kThreadedFineNodes)
  for (int n = 0; n < num_fine; ++n) {
    const int first = parents_start[n];
    const int last = parents_start[n + 1];
    const float weight = 1.0F / static_cast<float>(last - first);
    for (int a = 0; a < 3; ++a) {
      float sum = 0.0F;
      for (int i = first; i < last; ++i) sum += coarse[a * num_coarse + parents[i]];
      const auto dof = a * num_fine + n;
      result[dof] = fine.held[static_cast<std::size_t>(dof)] != 0 ? 0.0F : weight * sum;
    }
  }
}

void CoarseGrid::restrict_to_coarse(const TypedGrid& fine,
                                    const float* residual,
                                    float* result) const {
  const int num_fine = fine.grid.num_nodes();
  const int num_coarse = cells.grid.num_nodes();
#pragma omp parallel for schedule(static) if (num_fine > kThreadedFineNodes)
  for (int n = 0; n < num_coarse; ++n) {
    float sum[3] = {};
    for (int i = children_start[n]; i < children_start[n + 1]; ++i) {
      const int child = children[i];
      const float weight =
          1.0F / static_cast<float>(parents_start[child + 1] - parents_start[child]);
      for (int a = 0; a < 3; ++a) sum[a] += weight * residual[a * num_fine + child];
    }
    for (int a = 0; a < 3; ++a) {
      const auto dof = a * num_coarse + n;
      result[dof] = cells.held[static_cast<std::size_t>(dof)] != 0 ? 0.0F : sum[a];
    }
  }
}

std::vector<Eigen::MatrixXd> CoarseGrid::matrices(
    const std::vector<Eigen::MatrixXd>& of_fine) const {
  std::array<Eigen::Matrix<double, 8, 8>, 8> P;
  for (int part = 0; part < 8; ++part) P[static_cast<std::size_t>(part)] = interpolation(part);
  std::vector<Eigen::MatrixXd> result(parts_of_type.size());
#pragma omp parallel for schedule(static) if (parts_of_type.size() > 100)
  for (std::size_t t = 0; t < parts_of_type.size(); ++t) {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(24, 24);
    for (std::size_t part = 0; part < 8; ++part) {
      if (parts_of_type[t][part] < 0) continue;
      const Eigen::MatrixXd& fine = of_fine[static_cast<std::size_t>(parts_of_type[t][part])];
      for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) {
          const Eigen::Matrix<double, 8, 8> block = fine.block<8, 8>(8 * a, 8 * b);
          sum.block<8, 8>(8 * a, 8 * b) += P[part].transpose() * (block * P[part]);
        }
      }
    }
    zero_held(cells.held_of_type[t], sum);
    result[t] = sum;
  }
  return result;
}

}  // namespace twang
