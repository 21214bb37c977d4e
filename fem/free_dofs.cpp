// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "fem/elastic_body.hpp"

#include <fmt/format.h>

namespace twang {

namespace {

std::vector<char> held_marks(int num_nodes, const std::vector<int>& held_dofs) {
  std::vector<char> held(static_cast<std::size_t>(3 * num_nodes), 0);
  for (const int dof : held_dofs) {
    if (dof < 0 || dof >= 3 * num_nodes) {
      throw InputError(
          fmt::format("held degree of freedom is {}, must be in 0..{}", dof, 3 * num_nodes - 1));
    }
    held[static_cast<std::size_t>(dof)] = 1;
  }
  return held;
}

std::vector<int> dofs_of_nodes(int num_nodes, const std::vector<int>& nodes) {
  std::vector<int> dofs;
  for (const int node : nodes) {
    if (node < 0 || node >= num_nodes) {
      throw InputError(fmt::format("held node is {}, must be in 0..{}", node, num_nodes - 1));
    }
    for (int axis = 0; axis < 3; ++axis) dofs.push_back(3 * node + axis);
  }
  return dofs;
}

}  // namespace

FreeDofs::FreeDofs(const std::vector<char>& held) : m_free_from_full(held.size(), -1) {
  for (std::size_t full = 0; full < held.size(); ++full) {
    if (held[full] != 0) continue;
    m_free_from_full[full] = static_cast<int>(m_full_from_free.size());
    m_full_from_free.push_back(static_cast<int>(full));
  }
}

FreeDofs::FreeDofs(int num_nodes, const std::vector<int>& held_nodes)
    : FreeDofs(held_marks(num_nodes, dofs_of_nodes(num_nodes, held_nodes))) {}

FreeDofs FreeDofs::from_held_dofs(int num_nodes, const std::vector<int>& held_dofs) {
  return FreeDofs(held_marks(num_nodes, held_dofs));
}

std::vector<int> FreeDofs::held_dofs() const {
  std::vector<int> held;
  for (std::size_t full = 0; full < m_free_from_full.size(); ++full) {
    if (m_free_from_full[full] < 0) held.push_back(static_cast<int>(full));
  }
  return held;
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
