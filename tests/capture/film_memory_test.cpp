// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/track_markers.hpp"
#include "capture/video_writer.hpp"
#include "tests/capture/filmed_rig.hpp"
#include "tests/capture/filmed_strip.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace twang::test {
namespace {

/// Largest memory of a process of its own that does `work` [bytes]; 0 if it failed.
double peak_memory(const std::function<void()>& work) {
  const pid_t child = fork();
  if (child == 0) {
    try {
      work();
    } catch (...) {
      _exit(1);
    }
    _exit(0);
  }
  rusage usage{};
  int status = 1;
  if (child < 0 || wait4(child, &status, 0, &usage) != child || status != 0) return 0.0;
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

TEST(TrackerMemory, GrowsByTheTraceAndNoMore) {
  // Six frames a period without damping: the film goes round.
  const Rig rig = strip_rig();
  const StripMotion motion{.amplitude_m = 2e-3, .decay_per_s = 0.0, .release_s = 0.0};
  FilmOptions options;
  options.width_px = 320;
  options.height_px = 180;
  options.duration_s = 0.1;
  options.crf = 0;
  const TemporaryFolder folder;
  const auto loop = folder.path() / "loop.mkv";
  render_film(
      rig, [&](double time_s) { return motion.state_at(rig, time_s); }, loop, options);
  const std::vector<Image> images = read_film(loop);
  ASSERT_EQ(images.size(), 24U);

  const auto peak_of = [&](std::size_t frames) {
    const auto path = folder.path() / "long.mkv";
    {
      VideoWriter writer(path, 320, 180, {.fps = 240.0, .quick = true});
      for (std::size_t n = 0; n < frames; ++n) writer.write(images[n % images.size()]);
      writer.finish();
    }
    return peak_memory([&] { static_cast<void>(track_markers(rig, path)); });
  };
  const double little = peak_of(500);
  const double much = peak_of(5000);
  ASSERT_GT(little, 0.0);
  ASSERT_GT(much, 0.0);
  RecordProperty("bytes_a_frame", std::to_string((much - little) / 4500.0));
  // Five markers: position and sigma (24 bytes), three channels (24), the positions they are made
  // of (24) and growing vectors' slack, twice over at most, and some per frame: 1 kB. A picture
  // kept, be it one packet a frame, is more than 1.5 kB.
  EXPECT_LT((much - little) / 4500.0, 1500.0);
}

}  // namespace
}  // namespace twang::test
