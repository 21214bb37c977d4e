// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/time_base.hpp"
#include "capture/video_reader.hpp"
#include "core/atomic_file.hpp"
#include "tests/capture/foreign_film.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <random>
#include <string>
#include <vector>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 40;
constexpr std::size_t kTransportPacket = 188;  // [bytes]

struct Film {
  const char* file;
  const char* codec;
  const char* pixel_format;
};
void PrintTo(const Film& film, std::ostream* out) { *out << film.file; }

/// Highest memory of this program so far [MB].
double peak_memory_mb() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

/// What came of reading a film to its end.
struct Outcome {
  std::string refusal;  ///< empty if it was read
  int frames = 0;
  TimeBaseSummary time;
};
Outcome read_to_the_end(const fs::path& path) {
  Outcome outcome;
  try {
    VideoReader reader(path);
    std::vector<double> stamps;
    std::uint8_t corners = 0;
    while (const auto frame = reader.read()) {
      // Every byte that is promised is there.
      corners ^= frame->pixels[0];
      corners ^= frame->pixels[(frame->height_px - 1) * frame->stride + frame->width_px - 1];
      stamps.push_back(frame->stamp_s);
    }
    EXPECT_TRUE(corners < 256);
    outcome.frames = static_cast<int>(stamps.size());
    outcome.time =
        correct_time_base(stamps, reader.info().tick_s, reader.info().declared_fps, {}).summary;
  } catch (const InputError& error) {
    outcome.refusal = error.what();
  }
  return outcome;
}

class DamagedFilm : public ::testing::TestWithParam<Film> {
 protected:
  /// The bytes of a healthy film.
  std::string healthy() {
    const fs::path path = m_folder.path() / GetParam().file;
    ForeignFilm film;
    film.codec = GetParam().codec;
    film.pixel_format = GetParam().pixel_format;
    film.ticks_per_s = 30;
    for (int n = 0; n < kFrames; ++n) film.stamps.push_back(n);
    write_foreign_film(path, film);
    EXPECT_EQ(read_to_the_end(path).frames, kFrames);
    return read_file(path);
  }
  fs::path damaged(const std::string& bytes) {
    return m_folder.write(std::string("damaged_") + GetParam().file, bytes);
  }

 private:
  TemporaryFolder m_folder;
};

TEST_P(DamagedFilm, OfFlippedBytesIsReadOrRefused) {
  const std::string whole = healthy();
  constexpr unsigned kVariants = 50;
  constexpr std::size_t kHead = 700;   // where a container's headers are, or at the end
  constexpr double kMaxSeconds = 5.0;  // a healthy one takes 0.01; a sanitizer ten times that
#ifdef __SANITIZE_ADDRESS__
  constexpr double kWithheld_mb = 256.0;  // freed memory that the sanitizer keeps to watch over
#else
  constexpr double kWithheld_mb = 0.0;
#endif
  // a picture is 3 kB; decoders on all threads
  constexpr double kMaxMemory_mb = 150.0 + kWithheld_mb;
  const double memory_before = peak_memory_mb();
  int refused = 0;
  for (unsigned variant = 0; variant < kVariants; ++variant) {
    std::mt19937 random(variant);
    std::string bytes = whole;
    const std::size_t part = variant % 3 == 2 ? bytes.size() : std::min(kHead, bytes.size());
    for (unsigned flip = 0; flip <= variant % 8; ++flip) {
      const std::size_t at = random() % part;
      bytes[variant % 3 == 1 ? bytes.size() - 1 - at : at] = static_cast<char>(random());
    }
    const fs::path path = damaged(bytes);
    const auto start = std::chrono::steady_clock::now();
    const Outcome outcome = read_to_the_end(path);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    EXPECT_LT(took.count(), kMaxSeconds) << variant;
    EXPECT_LE(outcome.frames, kFrames + 1) << variant;  // a wrecked header may show a cut picture
    if (!outcome.refusal.empty()) {
      ++refused;
      // One sentence, and about this file or its stamps.
      EXPECT_EQ(outcome.refusal.find('\n'), std::string::npos) << outcome.refusal;
      EXPECT_TRUE(outcome.refusal.find("damaged_") != std::string::npos ||
                  outcome.refusal.find("frame") != std::string::npos)
          << outcome.refusal;
    }
  }
  EXPECT_GT(refused, 0);
  EXPECT_LT(peak_memory_mb() - memory_before, kMaxMemory_mb);
}

TEST_P(DamagedFilm, CutAtEveryTenthIsNeverTakenForWhole) {
  const std::string whole = healthy();
  for (std::size_t tenth = 0; tenth < 10; ++tenth) {
    const Outcome outcome = read_to_the_end(damaged(whole.substr(0, whole.size() * tenth / 10)));
    // A transport stream states no length: cut between two of its packets it is a shorter film.
    const bool shorter = std::string(GetParam().file).ends_with(".ts") &&
                         whole.size() * tenth / 10 % kTransportPacket == 0;
    EXPECT_TRUE(!outcome.refusal.empty() || shorter) << tenth << ": " << outcome.frames;
    EXPECT_LT(outcome.frames, kFrames);
  }
}

INSTANTIATE_TEST_SUITE_P(Containers,
                         DamagedFilm,
                         ::testing::Values(Film{"h264.mp4", "libx264", "yuv420p"},
                                           Film{"mjpeg.mov", "mjpeg", "yuvj420p"},
                                           Film{"h264.mkv", "libx264", "yuv420p"},
                                           Film{"mjpeg.avi", "mjpeg", "yuvj420p"},
                                           Film{"mpeg4.avi", "mpeg4", "yuv420p"},
                                           Film{"h264.ts", "libx264", "yuv420p"}),
                         [](const auto& film) {
                           std::string name = film.param.file;
                           name[name.find('.')] = '_';
                           return name;
                         });

/// Memory of this program now [MB].
double memory_mb() {
  std::ifstream statm("/proc/self/statm");
  double total = 0.0;
  double resident = 0.0;
  statm >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1048576.0;
}

TEST(LongFilm, TakesHardlyMoreMemoryThanAShortOne) {
  const TemporaryFolder folder;
  constexpr int kLong = 100000;
  const auto write = [&](const char* name, int frames) {
    // In a process of its own: what it frees would hide what the reader takes.
    const pid_t child = fork();
    if (child == 0) {
      ForeignFilm film;
      film.codec = "mpeg4";
      film.ticks_per_s = 240;
      for (int n = 0; n < frames; ++n) film.stamps.push_back(n);
      write_foreign_film(folder.path() / name, film);
      _exit(0);
    }
    int status = -1;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
    return folder.path() / name;
  };
  const fs::path brief = write("brief.mp4", 2000);
  const fs::path lengthy = write("lengthy.mp4", kLong);
  EXPECT_EQ(read_to_the_end(brief).frames, 2000);
  const double before_mb = memory_mb();
  VideoReader reader(lengthy);
  int frames = 0;
  while (frames < kLong / 10 && reader.read()) ++frames;
  const double early_mb = memory_mb();
  while (reader.read()) ++frames;
  EXPECT_EQ(frames, kLong);
  // A stamp and two index entries a frame, 64 bytes, with room for their vectors to double.
  EXPECT_LT(early_mb - before_mb, 20.0);
  // Nothing is gathered while reading; some slack for the allocator.
  EXPECT_LT(memory_mb() - early_mb, 1.0);
}

}  // namespace
}  // namespace twang::test
