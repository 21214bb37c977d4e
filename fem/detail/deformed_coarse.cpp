// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/deformed_coarse.hpp"

#include "fem/detail/coarse_grid.hpp"
#include "fem/stiffness_solver.hpp"

#include <utility>
#include <vector>

namespace twang {
namespace {

using Functions = Eigen::SparseMatrix<double, Eigen::RowMajor>;

constexpr int kColours = 27;
/// A grid that saves less than this is not worth its while.
constexpr double kLeastCoarsening = 1.5;

bool is_held(const TypedGrid& cells, int axis, int node) {
  return cells.held[static_cast<std::size_t>(axis * cells.grid.num_nodes() + node)] != 0;
}

/// The coarse functions of one component on the finer grid's nodes.
Functions functions_of(const CoarseGrid& coarse, const TypedGrid& fine, int axis) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int n = 0; n < fine.grid.num_nodes(); ++n) {
    if (is_held(fine, axis, n)) continue;
    const int first = coarse.parents_start[n];
    const int last = coarse.parents_start[n + 1];
    for (int i = first; i < last; ++i) {
      const int parent = coarse.parents[i];
      if (!is_held(coarse.cells, axis, parent))
        entries.emplace_back(n, parent, 1.0 / (last - first));
    }
  }
  Functions result(fine.grid.num_nodes(), coarse.cells.grid.num_nodes());
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

Functions own_functions(const TypedGrid& cells, int axis) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int n = 0; n < cells.grid.num_nodes(); ++n) {
    if (!is_held(cells, axis, n)) entries.emplace_back(n, n, 1.0);
  }
  Functions result(cells.grid.num_nodes(), cells.grid.num_nodes());
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

/// The body's grid; how its cells differ plays no role here.
TypedGrid plain_grid(const VoxelBody& body) {
  TypedGrid result;
  result.grid = body.grid();
  result.held = body.held();
  result.type = Eigen::ArrayXi::Zero(result.grid.num_cells());
  result.num_types = 1;
  result.held_of_type = {0};
  return result;
}

}  // namespace

DeformedCoarse::DeformedCoarse(const VoxelBody& body, int max_dofs) {
  TypedGrid last = plain_grid(body);
  for (int axis = 0; axis < 3; ++axis)
    m_P[static_cast<std::size_t>(axis)] = own_functions(last, axis);
  while (last.num_free() > max_dofs) {
    CoarseGrid coarse(last);
    const int num_free = coarse.cells.num_free();
    if (num_free == 0 || num_free * kLeastCoarsening > last.num_free()) break;
    for (int axis = 0; axis < 3; ++axis) {
      Functions& P = m_P[static_cast<std::size_t>(axis)];
      P = Functions(P * functions_of(coarse, last, axis));
    }
    last = std::move(coarse.cells);
  }
  const CellGrid& grid = last.grid;
  m_neighbours.resize(kColours, grid.num_nodes());
  m_colour.resize(grid.num_nodes());
  m_free_index.setConstant(3, grid.num_nodes(), -1);
  for (int n = 0; n < grid.num_nodes(); ++n) {
    const Eigen::Vector3i at = grid.nodes().col(n);
    m_colour[n] = at[0] % 3 + 3 * (at[1] % 3) + 9 * (at[2] % 3);
    for (int d = 0; d < kColours; ++d) {
      m_neighbours(d, n) =
          grid.find_node(at + Eigen::Vector3i(d % 3 - 1, d / 3 % 3 - 1, d / 9 - 1));
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (!is_held(last, axis, n)) m_free_index(axis, n) = m_num_free++;
    }
  }
}

Eigen::VectorXd DeformedCoarse::prolong(const Eigen::VectorXd& coarse) const {
  const Eigen::Index nodes = m_P[0].rows();
  const Eigen::Index coarse_nodes = m_P[0].cols();
  Eigen::VectorXd fine(3 * nodes);
  for (Eigen::Index a = 0; a < 3; ++a) {
    fine.segment(a * nodes, nodes) =
        m_P[static_cast<std::size_t>(a)] * coarse.segment(a * coarse_nodes, coarse_nodes);
  }
  return fine;
}

Eigen::VectorXd DeformedCoarse::restrict_to_coarse(const Eigen::VectorXd& fine) const {
  const Eigen::Index nodes = m_P[0].rows();
  const Eigen::Index coarse_nodes = m_P[0].cols();
  Eigen::VectorXd coarse(3 * coarse_nodes);
  for (Eigen::Index a = 0; a < 3; ++a) {
    coarse.segment(a * coarse_nodes, coarse_nodes) =
        m_P[static_cast<std::size_t>(a)].transpose() * fine.segment(a * nodes, nodes);
  }
  return coarse;
}

SolveStatus DeformedCoarse::prepare(const Operator& A) {
  m_solver.reset();
  const auto num_nodes = static_cast<int>(m_P[0].cols());
  std::vector<Eigen::Triplet<double>> entries;
  for (int colour = 0; colour < kColours; ++colour) {
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::VectorXd probe = Eigen::VectorXd::Zero(3 * num_nodes);
      for (int n = 0; n < num_nodes; ++n) {
        if (m_colour[n] == colour && m_free_index(axis, n) >= 0) probe[axis * num_nodes + n] = 1.0;
      }
      const Eigen::VectorXd product = restrict_to_coarse(A(prolong(probe)));
      for (int n = 0; n < num_nodes; ++n) {
        for (const int column_node : m_neighbours.col(n)) {
          if (column_node < 0 || m_colour[column_node] != colour) continue;
          const int column = m_free_index(axis, column_node);
          if (column < 0) continue;
          for (int b = 0; b < 3; ++b) {
            const int row = m_free_index(b, n);
            if (row >= 0) entries.emplace_back(row, column, product[b * num_nodes + n]);
          }
        }
      }
    }
  }
  SparseMatrix matrix(m_num_free, m_num_free);
  matrix.setFromTriplets(entries.begin(), entries.end());
  auto solver = make_cholesky_solver();
  SolveStatus status = solver->analyze(matrix);
  if (status == SolveStatus::Ok) status = solver->factorize(matrix);
  if (status == SolveStatus::Ok) m_solver = std::move(solver);
  return status;
}

Eigen::VectorXd DeformedCoarse::solve(const Eigen::VectorXd& r) const {
  const Eigen::VectorXd restricted = restrict_to_coarse(r);
  const auto num_nodes = static_cast<int>(m_P[0].cols());
  Eigen::VectorXd b(m_num_free);
  const auto for_each_free = [&](auto&& work) {
    for (int n = 0; n < num_nodes; ++n) {
      for (int axis = 0; axis < 3; ++axis) {
        const int at = m_free_index(axis, n);
        if (at >= 0) work(at, axis * num_nodes + n);
      }
    }
  };
  for_each_free([&](int free, int dof) { b[free] = restricted[dof]; });
  Eigen::MatrixXd x;
  Eigen::VectorXd coarse = Eigen::VectorXd::Zero(3 * num_nodes);
  if (m_solver->solve(b, x) != SolveStatus::Ok) return Eigen::VectorXd::Zero(r.size());
  for_each_free([&](int free, int dof) { coarse[dof] = x(free, 0); });
  return prolong(coarse);
}

double DeformedCoarse::memory_bytes() const {
  constexpr double kEntry = 12.0;                     // a value and its column
  constexpr double kNode = 4.0 * (kColours + 1 + 3);  // what is kept of a coarse node
  double bytes = kNode * static_cast<double>(m_colour.size()) + estimate_factor_bytes(m_num_free);
  for (const Functions& P : m_P) {
    bytes += kEntry * static_cast<double>(P.nonZeros()) + 4.0 * static_cast<double>(P.rows());
  }
  return bytes;
}

}  // namespace twang
