// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/unseen_markers.hpp"

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace twang::detail {
namespace {

constexpr int kGivesScale = 2;  // markers from which scale and turn are known

struct Count {
  int all = 0;
  int seen = 0;
  [[nodiscard]] bool enough() const { return seen >= std::min(all, kGivesScale); }
};

/// What a rig's markers are there for, and how many of each were seen.
struct Uses {
  Count any, fixed, moving;
};

Uses count_uses(const Rig& rig, const std::vector<bool>& seen) {
  Uses uses;
  for (std::size_t i = 0; i < rig.markers.size(); ++i) {
    for (Count* count : {&uses.any, rig.markers[i].fixed ? &uses.fixed : &uses.moving}) {
      ++count->all;
      count->seen += seen[i] ? 1 : 0;
    }
  }
  return uses;
}

/// What an unseen marker is needed for; empty if for nothing.
std::string need_of(const Rig& rig, const Marker& marker, const Uses& uses) {
  if (rig.observable) {
    const std::vector<std::string>& ids = rig.observable->markers;
    if (std::find(ids.begin(), ids.end(), marker.id) != ids.end()) return "the observable";
  }
  if (marker.fixed && !uses.fixed.enough()) return "the scale";
  if (!marker.fixed && uses.moving.seen == 0) return "the motion";
  if (uses.fixed.all < kGivesScale && !uses.any.enough()) return "the scale";
  return "";
}

std::string warning_on(const Marker& marker, const Uses& uses, std::size_t num_frames) {
  std::string warning = fmt::format(
      "Marker '{}' was not found in any of {} frames: its columns are nan", marker.id, num_frames);
  if (marker.fixed) {
    warning += fmt::format(", and scale and perspective come from {} fixed markers instead of {}",
                           uses.fixed.seen,
                           uses.fixed.all);
  }
  return warning + ".";
}

}  // namespace

std::vector<Note> judge_unseen_markers(const Rig& rig,
                                       const std::vector<bool>& seen,
                                       const std::string& film,
                                       std::size_t num_frames) {
  const Uses uses = count_uses(rig, seen);
  std::vector<Note> notes;
  for (std::size_t i = 0; i < rig.markers.size(); ++i) {
    if (seen[i]) continue;
    const Marker& marker = rig.markers[i];
    const std::string need = need_of(rig, marker, uses);
    if (need.empty()) {
      notes.emplace_back(warning_on(marker, uses, num_frames), Severity::Warning);
      continue;
    }
    throw InputError(fmt::format(
        "{}: marker '{}' was not found in any of {} frames and is needed for {}, must be {} of "
        "{:g} mm in plain view; give --marker {}=x,y",
        film,
        marker.id,
        num_frames,
        need,
        with_article(to_string(marker.kind)),
        kMillimetresPerMetre * marker.size_m,
        marker.id));
  }
  return notes;
}

}  // namespace twang::detail
