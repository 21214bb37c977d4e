// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/first_layout.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace twang::detail {
namespace {

constexpr std::size_t kEvery = 12;     // frames passed over: a twelfth of those gone by
constexpr std::size_t kMostBack = 24;  // of the frames passed over are looked at
constexpr int kGrid_px = 8;            // of pixels that tell an empty picture
constexpr int kLeastRange = 15;        // between its darkest and brightest [grey levels]

/// Whether there is anything to be seen at all.
bool shows_something(const LumaFrame& frame) {
  int least = 255;
  int most = 0;
  for (int y = 0; y < frame.height_px; y += kGrid_px) {
    const std::uint8_t* row = frame.pixels + y * frame.stride;
    for (int x = 0; x < frame.width_px; x += kGrid_px) {
      least = std::min<int>(least, row[x]);
      most = std::max<int>(most, row[x]);
    }
  }
  return most - least >= kLeastRange;
}

class FirstLayoutSearch {
 public:
  FirstLayoutSearch(const Rig& rig,
                    const std::filesystem::path& video,
                    const std::map<std::string, Eigen::Vector2d>& start_px,
                    const ProgressCallback& progress)
      : m_rig(rig), m_video(video), m_starts(start_px), m_progress(progress) {}

  FirstLayout run();

 private:
  PartialLayout look(const LumaFrame& frame, std::size_t n);
  FirstLayout look_back(FirstLayout found, std::size_t from);
  [[noreturn]] void refuse() const;
  void tell(std::size_t n, const VideoReader& reader) const {
    report_progress(m_progress,
                    {"looking for the markers",
                     static_cast<double>(n),
                     static_cast<double>(reader.info().declared_frames.value_or(0))});
  }

  const Rig& m_rig;
  const std::filesystem::path& m_video;
  const std::map<std::string, Eigen::Vector2d>& m_starts;
  const ProgressCallback& m_progress;
  std::optional<PartialLayout> m_best;
  std::size_t m_num_looked_at = 0;
};

PartialLayout FirstLayoutSearch::look(const LumaFrame& frame, std::size_t n) {
  ++m_num_looked_at;
  const std::string picture = n == 0 ? "the first frame" : fmt::format("frame {}", n);
  return search_layout(frame, m_rig, m_starts, m_video.string(), picture);
}

/// An earlier usable frame among those passed over.
FirstLayout FirstLayoutSearch::look_back(FirstLayout found, std::size_t from) {
  const std::size_t step = 1 + (found.frame - from) / kMostBack;
  VideoReader reader(m_video);
  for (std::size_t n = 0; n < found.frame; ++n) {
    const auto frame = reader.read();
    if (!frame) break;
    tell(n, reader);
    if (n < from || (n - from) % step != 0 || !shows_something(*frame)) continue;
    PartialLayout layout = look(*frame, n);
    if (layout.usable && layout.num_found >= found.layout.num_found) return {n, std::move(layout)};
  }
  return found;
}

void FirstLayoutSearch::refuse() const {
  std::string problem = m_best->problem;
  if (m_num_looked_at > 1) {
    problem += fmt::format(" (the best of {} frames looked at, with {} of {} markers)",
                           m_num_looked_at,
                           m_best->num_found,
                           m_rig.markers.size());
  }
  throw InputError(problem);
}

FirstLayout FirstLayoutSearch::run() {
  auto reader = std::make_unique<VideoReader>(m_video);
  std::size_t next = 0;
  std::size_t after_last = 0;
  for (std::size_t n = 0; const auto frame = reader->read(); ++n) {
    tell(n, *reader);
    if (n < next || (n > 0 && !shows_something(*frame))) continue;
    PartialLayout layout = look(*frame, n);
    if (layout.usable) {
      FirstLayout found{n, std::move(layout)};
      if (n == 0) {
        found.reader = std::move(reader);
        found.shown = *frame;
        return found;
      }
      return n > after_last ? look_back(std::move(found), after_last) : std::move(found);
    }
    // Where another picture will hardly help, the films's end is soon reached.
    next = n + 1 + (layout.hopeless ? n : n / kEvery);
    after_last = n + 1;
    if (!m_best || layout.num_found > m_best->num_found) m_best = std::move(layout);
  }
  if (!m_best) {
    throw InputError(fmt::format("{}: holds no picture, must hold a film", m_video.string()));
  }
  refuse();
}

}  // namespace

FirstLayout find_first_layout(const Rig& rig,
                              const std::filesystem::path& video,
                              const std::map<std::string, Eigen::Vector2d>& start_px,
                              const ProgressCallback& progress) {
  return FirstLayoutSearch(rig, video, start_px, progress).run();
}

}  // namespace twang::detail
