// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/trace.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang {

const Channel* Trace::find(std::string_view name) const {
  const auto it = std::find_if(channels.begin(), channels.end(), [&](const Channel& channel) {
    return channel.name == name;
  });
  return it == channels.end() ? nullptr : &*it;
}

Channel* Trace::find(std::string_view name) {
  return const_cast<Channel*>(std::as_const(*this).find(name));
}

std::size_t Trace::num_finite(const Channel& channel) {
  return static_cast<std::size_t>(std::count_if(channel.values.begin(),
                                                channel.values.end(),
                                                [](double value) { return std::isfinite(value); }));
}

}  // namespace twang
