// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/cell_grid.hpp"

#include <algorithm>

namespace twang {
namespace {

constexpr int kLayersOfSlab = 4;
/// Below this many cells threads cost more than they give.
constexpr int kThreadedCells = 20'000;

int find_key(const std::vector<std::int64_t>& keys, std::int64_t key) {
  const auto at = std::lower_bound(keys.begin(), keys.end(), key);
  return at != keys.end() && *at == key ? static_cast<int>(at - keys.begin()) : -1;
}

void sort_unique(std::vector<std::int64_t>& keys) {
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

Eigen::Matrix3Xi places_of(const std::vector<std::int64_t>& keys, const std::int64_t* stride) {
  Eigen::Matrix3Xi places(3, static_cast<Eigen::Index>(keys.size()));
  for (Eigen::Index i = 0; i < places.cols(); ++i) {
    const std::int64_t key = keys[static_cast<std::size_t>(i)];
    places(0, i) = static_cast<int>(key % stride[0]);
    places(1, i) = static_cast<int>(key / stride[0] % (stride[1] / stride[0]));
    places(2, i) = static_cast<int>(key / stride[1]);
  }
  return places;
}

}  // namespace

CellGrid::CellGrid(const Eigen::Matrix3Xi& cells) {
  if (cells.cols() == 0) return;
  const Eigen::Vector3i size = cells.rowwise().maxCoeff().array() + 2;  // nodes along each axis
  m_stride[0] = size[0];
  m_stride[1] = m_stride[0] * size[1];
  const auto key_of = [this](const Eigen::Vector3i& at) {
    return at[0] + m_stride[0] * at[1] + m_stride[1] * at[2];
  };
  m_cell_keys.reserve(static_cast<std::size_t>(cells.cols()));
  for (Eigen::Index c = 0; c < cells.cols(); ++c) m_cell_keys.push_back(key_of(cells.col(c)));
  sort_unique(m_cell_keys);
  m_cells = places_of(m_cell_keys, m_stride);

  for (int edge = 0; edge < 4; ++edge) {
    const std::int64_t step = key_of({0, edge & 1, edge >> 1});
    std::int64_t last = -1;
    for (const std::int64_t key : m_cell_keys) {
      if (key + step != last) m_node_keys.push_back(key + step);
      m_node_keys.push_back(last = key + step + 1);
    }
    // Kept short: rows overlap along their edges.
    if (edge % 2 == 1) sort_unique(m_node_keys);
  }
  m_nodes = places_of(m_node_keys, m_stride);

  for (int c = 0; c < num_cells(); ++c) {
    const auto at = static_cast<std::size_t>(c);
    if (c > 0 && m_cell_keys[at] == m_cell_keys[at - 1] + 1 && m_cells(0, c) > 0) {
      ++m_rows.back().length;
      continue;
    }
    Row row{c, 1, {}};
    for (int edge = 0; edge < 4; ++edge) {
      row.first_node[static_cast<std::size_t>(edge)] =
          find_key(m_node_keys, m_cell_keys[at] + key_of({0, edge & 1, edge >> 1}));
    }
    const int slab = m_cells(2, c) / kLayersOfSlab;
    const int index = static_cast<int>(m_rows.size());
    m_rows.push_back(row);
    if (m_slabs.empty() || m_slabs.back().first_node_layer != slab * kLayersOfSlab) {
      m_slabs.push_back({index, index, slab * kLayersOfSlab, slab % 2});
    }
    m_slabs.back().last_row = index + 1;
  }
  m_threaded = num_cells() > kThreadedCells;
}

int CellGrid::find_node(const Eigen::Vector3i& at) const {
  if ((at.array() < 0).any() || at[0] >= m_stride[0] || at[1] >= m_stride[1] / m_stride[0]) {
    return -1;
  }
  return find_key(m_node_keys, at[0] + m_stride[0] * at[1] + m_stride[1] * at[2]);
}

int CellGrid::find_cell(const Eigen::Vector3i& at) const {
  if ((at.array() < 0).any() || at[0] >= m_stride[0] || at[1] >= m_stride[1] / m_stride[0]) {
    return -1;
  }
  return find_key(m_cell_keys, at[0] + m_stride[0] * at[1] + m_stride[1] * at[2]);
}

void CellGrid::for_each_row(const std::function<void(const Row& row)>& work) const {
  const int count = static_cast<int>(m_slabs.size());
  for (int parity = 0; parity < 2; ++parity) {
#pragma omp parallel for schedule(dynamic) if (m_threaded)
    for (int s = 0; s < count; ++s) {
      const Slab& slab = m_slabs[static_cast<std::size_t>(s)];
      if (slab.parity != parity) continue;
      for (int r = slab.first_row; r < slab.last_row; ++r) {
        work(m_rows[static_cast<std::size_t>(r)]);
      }
    }
  }
}

Eigen::Matrix<int, 8, Eigen::Dynamic> CellGrid::nodes_of_cells() const {
  Eigen::Matrix<int, 8, Eigen::Dynamic> nodes(8, num_cells());
  for (const Row& row : m_rows) {
    for (int i = 0; i < row.length; ++i) {
      for (int corner = 0; corner < 8; ++corner) {
        nodes(corner, row.first_cell + i) =
            row.first_node[static_cast<std::size_t>(corner >> 1)] + i + (corner & 1);
      }
    }
  }
  return nodes;
}

}  // namespace twang
