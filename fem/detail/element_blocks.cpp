// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/element_blocks.hpp"

#include "fem/detail/element_kernels.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>

namespace twang {
namespace {

constexpr int kBatchesPerBlock = 64;
/// Below this many nodes of elements (8 for a hex8) threads cost more than they give.
constexpr int kThreadedSize = 100'000;
constexpr std::size_t kMaxSharedColours = 64;

}  // namespace

ElementBlocks::ElementBlocks(const HexMesh& mesh) {
  m_threaded = mesh.elements.size() > kThreadedSize;
  const int num_batches = (mesh.num_elements() + kLanes - 1) / kLanes;
  std::vector<std::uint64_t> colours_at_node(static_cast<std::size_t>(mesh.num_nodes()), 0);
  for (int first = 0; first < num_batches; first += kBatchesPerBlock) {
    const Block block{first, std::min(first + kBatchesPerBlock, num_batches)};
    const int last_element = std::min(block.last_batch * kLanes, mesh.num_elements());
    const auto elements =
        mesh.elements.middleCols(first * kLanes, last_element - first * kLanes).reshaped();
    std::uint64_t taken = 0;
    for (const int node : elements) taken |= colours_at_node[static_cast<std::size_t>(node)];
    const auto index = static_cast<int>(m_blocks.size());
    m_blocks.push_back(block);
    const auto colour = static_cast<std::size_t>(std::countr_one(taken));
    if (colour >= kMaxSharedColours) {  // a mesh numbered at random: this block goes alone
      m_blocks_of_colour.push_back({index});
      continue;
    }
    for (const int node : elements) {
      colours_at_node[static_cast<std::size_t>(node)] |= std::uint64_t{1} << colour;
    }
    if (colour >= m_blocks_of_colour.size()) m_blocks_of_colour.resize(colour + 1);
    m_blocks_of_colour[colour].push_back(index);
  }
}

}  // namespace twang
