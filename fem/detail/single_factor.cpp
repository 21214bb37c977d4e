// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/single_factor.hpp"

#include <algorithm>

extern "C" {
void strsv_(const char* uplo,
            const char* trans,
            const char* diag,
            const int* n,
            const float* a,
            const int* lda,
            float* x,
            const int* incx);
void sgemv_(const char* trans,
            const int* m,
            const int* n,
            const float* alpha,
            const float* a,
            const int* lda,
            const float* x,
            const int* incx,
            const float* beta,
            float* y,
            const int* incy);
}

namespace twang {
namespace {

constexpr int kNext = 1;  // entries of vectors follow one another

/// x = L^-1 x, or L^-T x.
void solve_triangle(const char* trans, int n, const float* triangle, int num_rows, float* x) {
  strsv_("L", trans, "N", &n, triangle, &num_rows, x, &kNext);
}

/// y = alpha A x + beta y, or with A^T.
void multiply(const char* trans,
              int m,
              int n,
              float alpha,
              const float* rectangle,
              int num_rows,
              const float* x,
              float beta,
              float* y) {
  sgemv_(trans, &m, &n, &alpha, rectangle, &num_rows, x, &kNext, &beta, y, &kNext);
}

}  // namespace

template <class Index>
SingleFactor<Index>::SingleFactor(const cholmod_factor& factor)
    : m_factor(&factor),
      m_values(factor.xsize),
      m_x(static_cast<Eigen::Index>(factor.n)),
      m_below(static_cast<Eigen::Index>(factor.maxesize)) {
  const auto* values = static_cast<const double*>(factor.x);
  std::transform(values, values + factor.xsize, m_values.begin(), [](double value) {
    return static_cast<float>(value);
  });
}

template <class Index>
auto SingleFactor<Index>::supernode(std::size_t s) const -> Supernode {
  const auto* columns = static_cast<const Index*>(m_factor->super);
  const auto* row_starts = static_cast<const Index*>(m_factor->pi);
  const auto* value_starts = static_cast<const Index*>(m_factor->px);
  const auto* rows = static_cast<const Index*>(m_factor->s);
  return {columns[s],
          static_cast<int>(columns[s + 1] - columns[s]),
          static_cast<int>(row_starts[s + 1] - row_starts[s]),
          rows + row_starts[s],
          m_values.data() + value_starts[s]};
}

template <class Index>
void SingleFactor<Index>::forward(const Supernode& node) {
  float* own = m_x.data() + node.first_column;
  solve_triangle("N", node.num_columns, node.values, node.num_rows, own);
  const int num_below = node.num_rows - node.num_columns;
  if (num_below == 0) return;
  const float* rectangle = node.values + node.num_columns;
  multiply(
      "N", num_below, node.num_columns, 1.0F, rectangle, node.num_rows, own, 0.0F, m_below.data());
  for (int i = 0; i < num_below; ++i) m_x[node.rows[node.num_columns + i]] -= m_below[i];
}

template <class Index>
void SingleFactor<Index>::backward(const Supernode& node) {
  float* own = m_x.data() + node.first_column;
  const int num_below = node.num_rows - node.num_columns;
  if (num_below > 0) {
    for (int i = 0; i < num_below; ++i) m_below[i] = m_x[node.rows[node.num_columns + i]];
    const float* rectangle = node.values + node.num_columns;
    multiply("T",
             num_below,
             node.num_columns,
             -1.0F,
             rectangle,
             node.num_rows,
             m_below.data(),
             1.0F,
             own);
  }
  solve_triangle("T", node.num_columns, node.values, node.num_rows, own);
}

template <class Index>
void SingleFactor<Index>::solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  const Eigen::Map<const Eigen::Matrix<Index, Eigen::Dynamic, 1>> order(
      static_cast<const Index*>(m_factor->Perm), m_x.size());
  // Within the range of single precision, whatever the units.
  const double scale = b.cwiseAbs().maxCoeff();
  x.resize(b.size());
  if (!(scale > 0.0)) {
    x.setConstant(scale);
    return;
  }
  for (Eigen::Index i = 0; i < m_x.size(); ++i) m_x[i] = static_cast<float>(b[order[i]] / scale);
  const std::size_t count = m_factor->nsuper;
  for (std::size_t s = 0; s < count; ++s) forward(supernode(s));
  for (std::size_t s = count; s-- > 0;) backward(supernode(s));
  for (Eigen::Index i = 0; i < m_x.size(); ++i) x[order[i]] = scale * static_cast<double>(m_x[i]);
}

template class SingleFactor<int>;
template class SingleFactor<SuiteSparse_long>;

}  // namespace twang
