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

namespace {

/// Whose sample a column is: `tip` of `tip.x_mm`, `observable` of `observable_mm`, else the column.
std::string_view owner_of(std::string_view name) {
  constexpr std::string_view kObservable = "observable";
  if (name.starts_with("observable_")) return kObservable;
  return name.substr(0, name.rfind('.'));
}

}  // namespace

const Channel* Trace::time_offset_of(std::string_view name) const {
  const std::string_view owner = owner_of(name);
  return owner == name ? nullptr : find(std::string(owner) + ".time_offset_s");
}

const Channel* Trace::sigma_of(std::string_view name) const {
  const std::string start = std::string(owner_of(name)) + ".sigma_";
  const auto it = std::find_if(channels.begin(), channels.end(), [&](const Channel& channel) {
    return channel.name.starts_with(start);
  });
  return it == channels.end() ? nullptr : &*it;
}

std::size_t Trace::num_finite(const Channel& channel) {
  return static_cast<std::size_t>(std::count_if(channel.values.begin(),
                                                channel.values.end(),
                                                [](double value) { return std::isfinite(value); }));
}

}  // namespace twang
