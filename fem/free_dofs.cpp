// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "fem/elastic_body.hpp"

#include <fmt/format.h>

namespace twang {

FreeDofs::FreeDofs(int num_nodes, const std::vector<int>& held_nodes)
    : m_free_from_full(static_cast<std::size_t>(3 * num_nodes), 0) {
  for (const int node : held_nodes) {
    if (node < 0 || node >= num_nodes) {
      throw InputError(fmt::format("held node is {}, must be in 0..{}", node, num_nodes - 1));
    }
    for (int i = 0; i < 3; ++i) m_free_from_full[static_cast<std::size_t>(3 * node + i)] = -1;
  }
  for (std::size_t full = 0; full < m_free_from_full.size(); ++full) {
    if (m_free_from_full[full] < 0) continue;
    m_free_from_full[full] = static_cast<int>(m_full_from_free.size());
    m_full_from_free.push_back(static_cast<int>(full));
  }
}

Eigen::VectorXd FreeDofs::restrict_vector(const Eigen::VectorXd& full) const {
  return full(m_full_from_free);
}

Eigen::VectorXd FreeDofs::expand_vector(const Eigen::VectorXd& free) const {
  Eigen::VectorXd full = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(m_free_from_full.size()));
  full(m_full_from_free) = free;
  return full;
}

SparseMatrix FreeDofs::restrict_matrix(const SparseMatrix& full) const {
  SparseMatrix result(size(), size());
  int* outer = result.outerIndexPtr();
  int count = 0;
  for (int column = 0; column < size(); ++column) {
    outer[column] = count;
    const int from = m_full_from_free[static_cast<std::size_t>(column)];
    for (SparseMatrix::InnerIterator entry(full, from); entry; ++entry) {
      count += m_free_from_full[static_cast<std::size_t>(entry.row())] >= 0 ? 1 : 0;
    }
  }
  outer[size()] = count;
  result.resizeNonZeros(count);
  int* inner = result.innerIndexPtr();
  double* value = result.valuePtr();
  for (const int from : m_full_from_free) {
    for (SparseMatrix::InnerIterator entry(full, from); entry; ++entry) {
      const int row = m_free_from_full[static_cast<std::size_t>(entry.row())];
      if (row < 0) continue;
      *inner++ = row;
      *value++ = entry.value();
    }
  }
  return result;
}

}  // namespace twang
