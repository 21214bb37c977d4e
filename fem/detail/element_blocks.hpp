// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/hex_mesh.hpp"

#include <vector>

namespace twang {

/// Runs of consecutive batches of elements, coloured so that blocks of one colour share no node and
/// may be added into the same vector or matrix at the same time. Sums come out the same for any
/// number of threads.
class ElementBlocks {
 public:
  explicit ElementBlocks(const HexMesh& mesh);

  struct Block {
    int first_batch = 0;
    int last_batch = 0;  ///< one past
  };
  [[nodiscard]] const std::vector<Block>& blocks() const { return m_blocks; }
  [[nodiscard]] int num_colours() const { return static_cast<int>(m_blocks_of_colour.size()); }

  /// Calls work(batch) for every batch, on several threads where the mesh is large enough to repay
  /// them.
  template <class Work>
  void for_each_batch(const Work& work) const {
    for (const std::vector<int>& colour : m_blocks_of_colour) {
      const int count = static_cast<int>(colour.size());
#pragma omp parallel for schedule(dynamic) if (m_threaded && count > 1)
      for (int i = 0; i < count; ++i) {
        const Block& block =
            m_blocks[static_cast<std::size_t>(colour[static_cast<std::size_t>(i)])];
        for (int batch = block.first_batch; batch < block.last_batch; ++batch) work(batch);
      }
    }
  }

 private:
  std::vector<Block> m_blocks;
  std::vector<std::vector<int>> m_blocks_of_colour;
  bool m_threaded = false;
};

}  // namespace twang
