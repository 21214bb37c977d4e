// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/doubled_frames.hpp"
#include "capture/detail/local_fit.hpp"
#include "capture/detail/path.hpp"

#include <cstddef>
#include <vector>

namespace twang::detail {

/// Which frames around say where a marker should be.
enum class Witness { Different, NoRepeat };

/// Which frames take time; every so many frames one does not, if `period` is not 0.
struct RepeatClock {
  enum class Count { All, NoRepeat, NeitherThis, Different };
  Count count = Count::All;
  std::size_t period = 0;
};

/// Of a frame: where its witnesses are taken from.
enum class WitnessSide { Both, Before, After };

/// What the frames around one say of it while it is judged, some of them being known for repeats.
class RepeatWitnesses {
 public:
  static constexpr std::size_t kReach = 44;   ///< frames on either side among which they are
  static constexpr std::size_t kAround = 12;  ///< frames on either side that say what is usual

  /// Both are looked at as they are at each call: they outlive this.
  RepeatWitnesses(const std::vector<Likeness>& likeness, const std::vector<bool>& repeats)
      : m_likeness(likeness), m_repeats(repeats) {}

  /// The nearest samples on both sides of a frame, timed from it.
  [[nodiscard]] Samples samples(const Path& path,
                                std::size_t frame,
                                Witness witness,
                                RepeatClock clock,
                                WitnessSide side = WitnessSide::Both) const;
  /// Time from `frame` to a frame before it.
  [[nodiscard]] double time_before(std::size_t n, std::size_t frame, RepeatClock clock) const;
  /// Of the samples.
  [[nodiscard]] double range(const Path& path, std::size_t frame, Witness witness) const;
  /// Whether so many frames before and after this one there are always pictures that are alike.
  [[nodiscard]] bool recurs(std::size_t frame, std::size_t period) const;
  /// Whether a lively motion has just begun or is about to end: no one vibration fits both sides.
  [[nodiscard]] bool begin_or_end(const Path& path, std::size_t frame) const;
  /// How far off a motion the pictures are that are alike and no repeats, one standard deviation; 0
  /// where these are too few. A coder leaves what moved by little where it was, more so than the
  /// pictures that differ tell.
  [[nodiscard]] double off_where_alike(const Path& path,
                                       const LocalFit& fit,
                                       std::size_t frame) const;

 private:
  [[nodiscard]] bool may_use(std::size_t n, Witness witness) const;
  [[nodiscard]] bool takes_time(std::size_t n, std::size_t frame, RepeatClock clock) const;

  const std::vector<Likeness>& m_likeness;
  const std::vector<bool>& m_repeats;
};

}  // namespace twang::detail
