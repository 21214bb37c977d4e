// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/linear_solver.hpp"

#include <cholmod.h>
#include <omp.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace twang {
namespace {

using Long = SuiteSparse_long;

/// Runs a call in one thread of OpenMP: CHOLMOD opens regions of its own that cost small problems
/// more than they give (its dense kernels have the threads of the BLAS).
class SingleThreadedRegions {
 public:
  SingleThreadedRegions() : m_levels(omp_get_max_active_levels()) { omp_set_max_active_levels(0); }
  ~SingleThreadedRegions() { omp_set_max_active_levels(m_levels); }
  SingleThreadedRegions(const SingleThreadedRegions&) = delete;
  SingleThreadedRegions& operator=(const SingleThreadedRegions&) = delete;

 private:
  int m_levels;
};

/// Groups of consecutive columns with one and the same pattern (the three unknowns of a node):
/// ordering one vertex for each group is faster than ordering the columns, and as good.
struct ColumnGroups {
  std::vector<Long> group_of_column;
  std::vector<Long> start;  ///< first column of each group, and one past the last
};

ColumnGroups group_columns(const SparseMatrix& A) {
  ColumnGroups groups;
  const int* outer = A.outerIndexPtr();
  const int* inner = A.innerIndexPtr();
  for (int j = 0; j < A.cols(); ++j) {
    const bool same = j > 0 && outer[j + 1] - outer[j] == outer[j] - outer[j - 1] &&
                      std::equal(inner + outer[j], inner + outer[j + 1], inner + outer[j - 1]);
    if (!same) groups.start.push_back(j);
    groups.group_of_column.push_back(static_cast<Long>(groups.start.size()) - 1);
  }
  groups.start.push_back(A.cols());
  return groups;
}

class CholeskySolver final : public LinearSolver {
 public:
  CholeskySolver() {
    cholmod_l_start(&m_common);
    m_common.print = 0;
    m_common.error_handler = nullptr;
    m_common.supernodal = CHOLMOD_SUPERNODAL;
    m_common.quick_return_if_not_posdef = 1;
    m_common.try_catch = 1;
  }
  ~CholeskySolver() override {
    release();
    cholmod_l_finish(&m_common);
  }
  CholeskySolver(const CholeskySolver&) = delete;
  CholeskySolver& operator=(const CholeskySolver&) = delete;

  SolveStatus analyze(const SparseMatrix& A) override;
  SolveStatus factorize(const SparseMatrix& A) override;
  SolveStatus solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) override;
  [[nodiscard]] std::string name() const override { return "CHOLMOD supernodal Cholesky"; }

 private:
  void release();
  [[nodiscard]] SolveStatus status() const;
  [[nodiscard]] cholmod_sparse view(const SparseMatrix& A);
  [[nodiscard]] std::vector<Long> ordering(const SparseMatrix& A);

  cholmod_common m_common{};
  cholmod_factor* m_factor = nullptr;
  cholmod_dense* m_solution = nullptr;
  cholmod_dense* m_workspace_y = nullptr;
  cholmod_dense* m_workspace_e = nullptr;
  std::vector<Long> m_outer;  ///< of the analysed pattern
  std::vector<Long> m_inner;
  bool m_factorized = false;
};

void CholeskySolver::release() {
  cholmod_l_free_factor(&m_factor, &m_common);
  cholmod_l_free_dense(&m_solution, &m_common);
  cholmod_l_free_dense(&m_workspace_y, &m_common);
  cholmod_l_free_dense(&m_workspace_e, &m_common);
  m_factorized = false;
}

SolveStatus CholeskySolver::status() const {
  switch (m_common.status) {
    case CHOLMOD_OK:
      return SolveStatus::Ok;
    case CHOLMOD_NOT_POSDEF:
    case CHOLMOD_DSMALL:
      return SolveStatus::NotPositiveDefinite;
    case CHOLMOD_OUT_OF_MEMORY:
    case CHOLMOD_TOO_LARGE:
      return SolveStatus::OutOfMemory;
    default:
      return SolveStatus::Failed;
  }
}

/// The upper triangle of A, in CHOLMOD's eyes; the values stay where they are.
cholmod_sparse CholeskySolver::view(const SparseMatrix& A) {
  cholmod_sparse result{};
  result.nrow = static_cast<std::size_t>(A.rows());
  result.ncol = static_cast<std::size_t>(A.cols());
  result.nzmax = m_inner.size();
  result.p = m_outer.data();
  result.i = m_inner.data();
  result.x = const_cast<double*>(A.valuePtr());  // CHOLMOD does not write to its input
  result.stype = 1;
  result.itype = CHOLMOD_LONG;
  result.xtype = CHOLMOD_REAL;
  result.dtype = CHOLMOD_DOUBLE;
  result.sorted = 1;
  result.packed = 1;
  return result;
}

/// Nested dissection (METIS) of the graph of column groups, expanded to the columns; empty if that
/// fails.
std::vector<Long> CholeskySolver::ordering(const SparseMatrix& A) {
  const ColumnGroups groups = group_columns(A);
  const std::size_t num_groups = groups.start.size() - 1;
  std::vector<Long> outer = {0};
  std::vector<Long> inner;
  for (std::size_t g = 0; g < num_groups; ++g) {
    const Long column = groups.start[g];
    Long last = -1;
    for (int at = A.outerIndexPtr()[column]; at < A.outerIndexPtr()[column + 1]; ++at) {
      const Long row = groups.group_of_column[static_cast<std::size_t>(A.innerIndexPtr()[at])];
      if (row > static_cast<Long>(g)) break;
      if (row != last) inner.push_back(row);
      last = row;
    }
    outer.push_back(static_cast<Long>(inner.size()));
  }
  cholmod_sparse graph{};
  graph.nrow = graph.ncol = num_groups;
  graph.nzmax = inner.size();
  graph.p = outer.data();
  graph.i = inner.data();
  graph.stype = 1;
  graph.itype = CHOLMOD_LONG;
  graph.xtype = CHOLMOD_PATTERN;
  graph.sorted = 1;
  graph.packed = 1;
  std::vector<Long> group_order(num_groups);
  if (!cholmod_l_metis(&graph, nullptr, 0, 1, group_order.data(), &m_common)) return {};
  std::vector<Long> order;
  for (const Long g : group_order) {
    const auto at = static_cast<std::size_t>(g);
    for (Long column = groups.start[at]; column < groups.start[at + 1]; ++column) {
      order.push_back(column);
    }
  }
  return order;
}

SolveStatus CholeskySolver::analyze(const SparseMatrix& A) {
  if (A.rows() != A.cols() || A.rows() == 0 || !A.isCompressed()) return SolveStatus::Failed;
  release();
  const SingleThreadedRegions single;
  m_outer.assign(A.outerIndexPtr(), A.outerIndexPtr() + A.cols() + 1);
  m_inner.assign(A.innerIndexPtr(), A.innerIndexPtr() + A.nonZeros());
  std::vector<Long> order = ordering(A);
  cholmod_sparse matrix = view(A);
  m_common.nmethods = 1;
  m_common.method[0].ordering = order.empty() ? CHOLMOD_AMD : CHOLMOD_GIVEN;
  m_common.postorder = 1;
  m_factor =
      cholmod_l_analyze_p(&matrix, order.empty() ? nullptr : order.data(), nullptr, 0, &m_common);
  return m_factor != nullptr ? SolveStatus::Ok : status();
}

SolveStatus CholeskySolver::factorize(const SparseMatrix& A) {
  m_factorized = false;
  const bool same_pattern = m_factor != nullptr && A.isCompressed() &&
                            A.cols() + 1 == static_cast<Eigen::Index>(m_outer.size()) &&
                            A.nonZeros() == static_cast<Eigen::Index>(m_inner.size());
  if (!same_pattern) return SolveStatus::Failed;
  const SingleThreadedRegions single;
  cholmod_sparse matrix = view(A);
  const bool done = cholmod_l_factorize(&matrix, m_factor, &m_common) != 0;
  if (!done || m_common.status != CHOLMOD_OK) return status();
  if (m_factor->minor < m_factor->n) return SolveStatus::NotPositiveDefinite;
  m_factorized = true;
  return SolveStatus::Ok;
}

SolveStatus CholeskySolver::solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) {
  if (!m_factorized) return SolveStatus::NotFactorized;
  if (B.rows() != static_cast<Eigen::Index>(m_factor->n)) return SolveStatus::Failed;
  const SingleThreadedRegions single;
  cholmod_dense right{};
  right.nrow = right.d = static_cast<std::size_t>(B.rows());
  right.ncol = static_cast<std::size_t>(B.cols());
  right.nzmax = static_cast<std::size_t>(B.size());
  right.x = const_cast<double*>(B.data());  // CHOLMOD does not write to its input
  right.xtype = CHOLMOD_REAL;
  right.dtype = CHOLMOD_DOUBLE;
  const bool done = cholmod_l_solve2(CHOLMOD_A,
                                     m_factor,
                                     &right,
                                     nullptr,
                                     &m_solution,
                                     nullptr,
                                     &m_workspace_y,
                                     &m_workspace_e,
                                     &m_common) != 0;
  if (!done) return status();
  X = Eigen::Map<const Eigen::MatrixXd>(
      static_cast<const double*>(m_solution->x), B.rows(), B.cols());
  return SolveStatus::Ok;
}

}  // namespace

std::unique_ptr<LinearSolver> make_cholesky_solver() { return std::make_unique<CholeskySolver>(); }

}  // namespace twang
