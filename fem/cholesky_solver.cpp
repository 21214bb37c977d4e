// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/cholesky_solver.hpp"

#include "fem/detail/cholmod_calls.hpp"
#include "fem/detail/single_factor.hpp"
#include "fem/detail/thread_limits.hpp"

#include <algorithm>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

namespace twang {
namespace {

/// A factorization with fewer operations, about 1 s, runs in one thread: a second one would gain
/// little on an idle machine and cost much on a busy one.
constexpr double kThreadedOperations = 5e10;
/// Groups of consecutive columns with one and the same pattern (the three unknowns of a node):
/// ordering one vertex for each group is faster than ordering the columns, and as good.
struct ColumnGroups {
  std::vector<int> group_of_column;
  std::vector<int> start;  ///< first column of each group, and one past the last

  [[nodiscard]] std::size_t count() const { return start.size() - 1; }
};

ColumnGroups group_columns(const SparseMatrix& A) {
  ColumnGroups groups;
  const int* outer = A.outerIndexPtr();
  const int* inner = A.innerIndexPtr();
  for (int j = 0; j < A.cols(); ++j) {
    const bool same = j > 0 && outer[j + 1] - outer[j] == outer[j] - outer[j - 1] &&
                      std::equal(inner + outer[j], inner + outer[j + 1], inner + outer[j - 1]);
    if (!same) groups.start.push_back(j);
    groups.group_of_column.push_back(static_cast<int>(groups.start.size()) - 1);
  }
  groups.start.push_back(static_cast<int>(A.cols()));
  return groups;
}

/// Upper triangle of the graph of column groups.
template <class Index>
struct GroupGraph {
  std::vector<Index> outer = {0};
  std::vector<Index> inner;

  GroupGraph(const SparseMatrix& A, const ColumnGroups& groups) {
    for (std::size_t g = 0; g < groups.count(); ++g) {
      const int column = groups.start[g];
      Index last = -1;
      for (int at = A.outerIndexPtr()[column]; at < A.outerIndexPtr()[column + 1]; ++at) {
        const Index row = groups.group_of_column[static_cast<std::size_t>(A.innerIndexPtr()[at])];
        if (row > static_cast<Index>(g)) break;
        if (row != last) inner.push_back(row);
        last = row;
      }
      outer.push_back(static_cast<Index>(inner.size()));
    }
  }
};

template <class Index>
class CholeskySolver final : public LinearSolver {
  using Calls = CholmodCalls<Index>;

 public:
  CholeskySolver() {
    Calls::start(&m_common);
    m_common.print = 0;
    m_common.supernodal = CHOLMOD_SUPERNODAL;
    m_common.quick_return_if_not_posdef = 1;
  }
  ~CholeskySolver() override {
    release();
    Calls::finish(&m_common);
  }
  CholeskySolver(const CholeskySolver&) = delete;
  CholeskySolver& operator=(const CholeskySolver&) = delete;

  SolveStatus analyze(const SparseMatrix& A) override;
  SolveStatus factorize(const SparseMatrix& A) override;
  SolveStatus solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) override;
  SolveStatus solve_roughly(const Eigen::VectorXd& b, Eigen::VectorXd& x) override;
  [[nodiscard]] std::string name() const override { return "CHOLMOD supernodal Cholesky"; }

 private:
  void release();
  [[nodiscard]] SolveStatus status() const;
  [[nodiscard]] cholmod_sparse view(const SparseMatrix& A);
  [[nodiscard]] std::vector<Index> ordering(const SparseMatrix& A);

  cholmod_common m_common{};
  cholmod_factor* m_factor = nullptr;
  cholmod_dense* m_solution = nullptr;
  cholmod_dense* m_workspace_y = nullptr;
  cholmod_dense* m_workspace_e = nullptr;
  Eigen::Index m_num_entries = 0;  ///< of the analysed pattern
  std::vector<Index> m_outer;      ///< copies of the pattern, unless Eigen's indices serve
  std::vector<Index> m_inner;
  double m_operations = 0.0;                    ///< of a factorization
  std::optional<SingleFactor<Index>> m_single;  ///< of the last one, where it was asked for
  bool m_factorized = false;
};

template <class Index>
void CholeskySolver<Index>::release() {
  Calls::free_factor(&m_factor, &m_common);
  Calls::free_dense(&m_solution, &m_common);
  Calls::free_dense(&m_workspace_y, &m_common);
  Calls::free_dense(&m_workspace_e, &m_common);
  m_single.reset();
  m_factorized = false;
}

template <class Index>
SolveStatus CholeskySolver<Index>::status() const {
  switch (m_common.status) {
    case CHOLMOD_OK:
      return SolveStatus::Ok;
    case CHOLMOD_NOT_POSDEF:
      return SolveStatus::NotPositiveDefinite;
    case CHOLMOD_OUT_OF_MEMORY:
    case CHOLMOD_TOO_LARGE:
      return SolveStatus::OutOfMemory;
    default:
      return SolveStatus::Failed;
  }
}

/// The upper triangle of A, in CHOLMOD's eyes; nothing is copied but indices to be widened.
/// CHOLMOD does not write to its input.
template <class Index>
cholmod_sparse CholeskySolver<Index>::view(const SparseMatrix& A) {
  cholmod_sparse result{};
  result.nrow = static_cast<std::size_t>(A.rows());
  result.ncol = static_cast<std::size_t>(A.cols());
  result.nzmax = static_cast<std::size_t>(A.nonZeros());
  if constexpr (std::is_same_v<Index, int>) {
    result.p = const_cast<int*>(A.outerIndexPtr());
    result.i = const_cast<int*>(A.innerIndexPtr());
  } else {
    result.p = m_outer.data();
    result.i = m_inner.data();
  }
  result.x = const_cast<double*>(A.valuePtr());
  result.stype = 1;
  result.itype = Calls::itype;
  result.xtype = CHOLMOD_REAL;
  result.dtype = CHOLMOD_DOUBLE;
  result.sorted = 1;
  result.packed = 1;
  return result;
}

/// Nested dissection of the graph of column groups, expanded to the columns; empty if that fails.
template <class Index>
std::vector<Index> CholeskySolver<Index>::ordering(const SparseMatrix& A) {
  const ColumnGroups groups = group_columns(A);
  GroupGraph<Index> upper(A, groups);
  cholmod_sparse graph{};
  graph.nrow = graph.ncol = groups.count();
  graph.nzmax = upper.inner.size();
  graph.p = upper.outer.data();
  graph.i = upper.inner.data();
  graph.stype = 1;
  graph.itype = Calls::itype;
  graph.xtype = CHOLMOD_PATTERN;
  graph.sorted = 1;
  graph.packed = 1;
  std::vector<Index> group_order(groups.count());
  std::vector<Index> parent(groups.count());
  std::vector<Index> member(groups.count());
  const auto num_components = Calls::nested_dissection(
      &graph, nullptr, 0, group_order.data(), parent.data(), member.data(), &m_common);
  if (num_components < 0) return {};
  std::vector<Index> order;
  order.reserve(static_cast<std::size_t>(A.cols()));
  for (const Index g : group_order) {
    const auto at = static_cast<std::size_t>(g);
    for (int column = groups.start[at]; column < groups.start[at + 1]; ++column) {
      order.push_back(column);
    }
  }
  return order;
}

template <class Index>
SolveStatus CholeskySolver<Index>::analyze(const SparseMatrix& A) {
  release();
  if (A.rows() != A.cols() || A.rows() == 0 || !A.isCompressed()) return SolveStatus::Failed;
  const ThreadLimits limits(true);
  m_num_entries = A.nonZeros();
  if constexpr (!std::is_same_v<Index, int>) {
    m_outer.assign(A.outerIndexPtr(), A.outerIndexPtr() + A.cols() + 1);
    m_inner.assign(A.innerIndexPtr(), A.innerIndexPtr() + A.nonZeros());
  }
  std::vector<Index> order = ordering(A);
  cholmod_sparse matrix = view(A);
  m_common.nmethods = 1;
  m_common.method[0].ordering = order.empty() ? CHOLMOD_AMD : CHOLMOD_GIVEN;
  m_common.postorder = 1;
  m_factor = Calls::analyze(&matrix, order.empty() ? nullptr : order.data(), nullptr, 0, &m_common);
  m_operations = m_common.fl;
  return m_factor != nullptr ? SolveStatus::Ok : status();
}

template <class Index>
SolveStatus CholeskySolver<Index>::factorize(const SparseMatrix& A) {
  m_single.reset();
  m_factorized = false;
  const bool same_size = m_factor != nullptr && A.isCompressed() && A.rows() == A.cols() &&
                         A.cols() == static_cast<Eigen::Index>(m_factor->n) &&
                         A.nonZeros() == m_num_entries;
  if (!same_size) return SolveStatus::Failed;
  const ThreadLimits limits(m_operations < kThreadedOperations || machine_is_busy());
  cholmod_sparse matrix = view(A);
  const bool done = Calls::factorize(&matrix, m_factor, &m_common) != 0;
  if (!done || m_common.status != CHOLMOD_OK) return status();
  if (m_factor->minor < m_factor->n) return SolveStatus::NotPositiveDefinite;
  m_factorized = true;
  return SolveStatus::Ok;
}

template <class Index>
SolveStatus CholeskySolver<Index>::solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) {
  if (!m_factorized) return SolveStatus::NotFactorized;
  if (B.rows() != static_cast<Eigen::Index>(m_factor->n)) return SolveStatus::Failed;
  const ThreadLimits limits(true);  // memory sets the pace
  cholmod_dense right{};
  right.nrow = right.d = static_cast<std::size_t>(B.rows());
  right.ncol = static_cast<std::size_t>(B.cols());
  right.nzmax = static_cast<std::size_t>(B.size());
  right.x = const_cast<double*>(B.data());
  right.xtype = CHOLMOD_REAL;
  right.dtype = CHOLMOD_DOUBLE;
  const bool done = Calls::solve(CHOLMOD_A,
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

template <class Index>
SolveStatus CholeskySolver<Index>::solve_roughly(const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  if (!m_factorized) return SolveStatus::NotFactorized;
  if (b.size() != static_cast<Eigen::Index>(m_factor->n)) return SolveStatus::Failed;
  const ThreadLimits limits(true);  // memory sets the pace
  if (!m_single) m_single.emplace(*m_factor);
  m_single->solve(b, x);
  return SolveStatus::Ok;
}

/// Narrow indices as long as the factor permits.
class AutomaticCholeskySolver final : public LinearSolver {
 public:
  SolveStatus analyze(const SparseMatrix& A) override {
    m_solver = make_narrow_cholesky_solver();
    const SolveStatus status = m_solver->analyze(A);
    if (status != SolveStatus::OutOfMemory) return status;
    m_solver = make_wide_cholesky_solver();
    return m_solver->analyze(A);
  }
  SolveStatus factorize(const SparseMatrix& A) override { return m_solver->factorize(A); }
  SolveStatus solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) override {
    return m_solver->solve(B, X);
  }
  SolveStatus solve_roughly(const Eigen::VectorXd& b, Eigen::VectorXd& x) override {
    return m_solver->solve_roughly(b, x);
  }
  [[nodiscard]] std::string name() const override { return m_solver->name(); }

 private:
  std::unique_ptr<LinearSolver> m_solver = make_narrow_cholesky_solver();
};

}  // namespace

std::unique_ptr<LinearSolver> make_narrow_cholesky_solver() {
  return std::make_unique<CholeskySolver<int>>();
}

std::unique_ptr<LinearSolver> make_wide_cholesky_solver() {
  return std::make_unique<CholeskySolver<SuiteSparse_long>>();
}

std::unique_ptr<LinearSolver> make_cholesky_solver() {
  return std::make_unique<AutomaticCholeskySolver>();
}

}  // namespace twang
