// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/lost_stretches.hpp"

#include <fmt/format.h>

namespace twang::detail {
namespace {

constexpr std::size_t kMostSentences = 3;  // on one marker

std::string frames_text(const LostStretch& stretch) {
  if (stretch.num_frames == 1) return fmt::format("frame {}", stretch.first_frame);
  return fmt::format(
      "frames {}-{}", stretch.first_frame, stretch.first_frame + stretch.num_frames - 1);
}

}  // namespace

void note_lost(MarkerTrack& track, std::size_t frame, const std::string& because) {
  if (track.frames_lost++ == 0) track.lost_because = because;
  if (!track.lost.empty()) {
    LostStretch& last = track.lost.back();
    if (last.first_frame + last.num_frames == frame) {
      ++last.num_frames;
      return;
    }
  }
  track.lost.push_back({frame, 1, because, false});
}

std::vector<Note> notes_on_losses(const MarkerTrack& track) {
  std::vector<Note> notes;
  std::size_t frames = 0;
  for (std::size_t k = 0; k < track.lost.size(); ++k) {
    const LostStretch& stretch = track.lost[k];
    if (k >= kMostSentences) {
      frames += stretch.num_frames;
      continue;
    }
    const std::size_t end = stretch.first_frame + stretch.num_frames;
    if (!stretch.found_again) {
      notes.emplace_back(fmt::format("Marker '{}' was lost in {} ({}) and not found again.",
                                     track.id,
                                     frames_text(stretch),
                                     stretch.reason),
                         Severity::Warning);
    } else if (stretch.first_frame == 0) {
      notes.emplace_back(fmt::format("Marker '{}' was first seen in frame {} ({} before).",
                                     track.id,
                                     stretch.num_frames,
                                     stretch.reason));
    } else {
      notes.emplace_back(fmt::format("Marker '{}' was lost in {} ({}) and found again in frame {}.",
                                     track.id,
                                     frames_text(stretch),
                                     stretch.reason,
                                     end));
    }
  }
  if (track.lost.size() > kMostSentences) {
    notes.emplace_back(fmt::format("Marker '{}' was lost {} times more, in {} frames.",
                                   track.id,
                                   track.lost.size() - kMostSentences,
                                   frames),
                       Severity::Warning);
  }
  return notes;
}

}  // namespace twang::detail
