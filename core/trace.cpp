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

const Channel* Trace::time_offset_of(std::string_view name) const {
  constexpr std::string_view kObservable = "observable";
  const bool observable = name.starts_with(std::string(kObservable) + '_');
  const std::size_t dot = name.rfind('.');
  if (!observable && dot == std::string_view::npos) return nullptr;
  const std::string_view owner = observable ? kObservable : name.substr(0, dot);
  return find(std::string(owner) + ".time_offset_s");
}

std::size_t Trace::num_finite(const Channel& channel) {
  return static_cast<std::size_t>(std::count_if(channel.values.begin(),
                                                channel.values.end(),
                                                [](double value) { return std::isfinite(value); }));
}

}  // namespace twang
