// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <opencv2/core/utility.hpp>

#include <cstddef>

namespace twang::detail {

/// Calls `work(i)` for i = 0 .. count - 1, several at a time, by OpenCV's threads; each call may
/// write only what is its own. The caller waits for all.
template <typename Work>
void for_each_in_parallel(std::size_t count, const Work& work) {
  cv::parallel_for_(
      {0, static_cast<int>(count)},
      [&](const cv::Range& some) {
        for (int i = some.start; i < some.end; ++i) work(static_cast<std::size_t>(i));
      },
      static_cast<double>(count));
}

}  // namespace twang::detail
