// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/video_reader.hpp"

#include "capture/video_writer.hpp"
#include "core/atomic_file.hpp"
#include "tests/capture/foreign_film.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

std::vector<double> read_stamps(const fs::path& path) {
  VideoReader reader(path);
  std::vector<double> stamps;
  while (const auto frame = reader.read()) stamps.push_back(frame->stamp_s);
  return stamps;
}

/// Stamps and the level of each picture of a film by `write_foreign_film`.
struct ReadFilm {
  std::vector<double> stamps;
  std::vector<int> levels;
};
ReadFilm read_levels(const fs::path& path) {
  VideoReader reader(path);
  ReadFilm film;
  while (const auto frame = reader.read()) {
    film.stamps.push_back(frame->stamp_s);
    film.levels.push_back(frame->pixels[20 * frame->stride + 30]);
  }
  return film;
}

std::vector<std::int64_t> even_stamps(int count, std::int64_t step, std::int64_t first = 0) {
  std::vector<std::int64_t> stamps;
  for (int n = 0; n < count; ++n) stamps.push_back(first + n * step);
  return stamps;
}

/// A film in which every picture costs about as many bytes as every other.
std::string noise_film(const fs::path& path, int frames) {
  VideoWriter writer(path, 64, 48, {.fps = 240.0, .crf = 20});
  std::mt19937 random(1);
  for (int n = 0; n < frames; ++n) {
    Image image{64, 48, 1, std::vector<std::uint8_t>(64 * 48)};
    for (auto& pixel : image.pixels) pixel = static_cast<std::uint8_t>(100 + random() % 64);
    writer.write(image);
  }
  writer.finish();
  return read_file(path);
}

class CutFilm : public ::testing::TestWithParam<const char*> {};

TEST_P(CutFilm, IsRefusedAtEveryTenthOfItsLength) {
  const TemporaryFolder folder;
  constexpr int kFrames = 100;
  const std::string whole = noise_film(folder.path() / GetParam(), kFrames);
  EXPECT_EQ(read_stamps(folder.path() / GetParam()).size(), kFrames);
  for (std::size_t tenth = 1; tenth < 10; ++tenth) {
    const fs::path cut =
        folder.write(std::string("cut_") + GetParam(), whole.substr(0, whole.size() * tenth / 10));
    const std::string said = refusal_of([&] { (void)read_stamps(cut); });
    EXPECT_TRUE(holds(said, cut.filename().string())) << tenth;
    EXPECT_TRUE(holds(said, "cut off")) << tenth;
  }
}

INSTANTIATE_TEST_SUITE_P(Containers,
                         CutFilm,
                         ::testing::Values("film.mp4", "film.mov", "film.mkv"),
                         [](const auto& film) {
                           return fs::path(film.param).extension().string().substr(1);
                         });

TEST(VideoReader, RefusesACutFilmWithItsIndexAtTheEnd) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "film.mp4";
  write_foreign_film(path, {.stamps = even_stamps(100, 64), .faststart = false});
  EXPECT_EQ(read_stamps(path).size(), 100U);
  const std::string whole = read_file(path);
  for (std::size_t tenth = 1; tenth < 10; ++tenth) {
    const fs::path cut = folder.write("cut.mp4", whole.substr(0, whole.size() * tenth / 10));
    EXPECT_TRUE(holds(refusal_of([&] { (void)read_stamps(cut); }), "cut off"));
  }
}

TEST(VideoReader, SaysAfterWhichFrameAFilmIsDamaged) {
  const TemporaryFolder folder;
  std::string bytes = noise_film(folder.path() / "film.mp4", 60);
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2), 2000, '\0');
  const fs::path path = folder.write("damaged.mp4", bytes);
  const std::string said = refusal_of([&] { (void)read_stamps(path); });
  EXPECT_TRUE(holds(said, "damaged.mp4: breaks off after frame "));
}

TEST(VideoReader, RefusesWhatIsNoFilm) {
  const TemporaryFolder folder;
  const auto refusal = [](const fs::path& path) {
    return refusal_of([&] { VideoReader reader(path); });
  };
  EXPECT_TRUE(holds(refusal(folder.path() / "none.mp4"), "none.mp4: no such file"));
  EXPECT_TRUE(holds(refusal(folder.path()), "is a folder"));
  EXPECT_TRUE(holds(refusal(folder.write("empty.mp4", "")), "empty.mp4: is empty"));
  const std::string text(5000, 'a');
  EXPECT_TRUE(holds(refusal(folder.write("text.txt", text)), "text.txt: cannot be opened"));
  EXPECT_TRUE(holds(refusal(folder.write("text.mp4", text)), "text.mp4: cannot be opened"));
  EXPECT_TRUE(holds(refusal(folder.write("list.m3u8", "#EXTM3U\n#EXTINF:1,\nfilm.ts\n")),
                    "list.m3u8: cannot be opened"));
  std::string noise(20000, ' ');
  std::mt19937 random(4);
  for (char& byte : noise) byte = static_cast<char>(random());
  EXPECT_TRUE(holds(refusal(folder.write("noise.avi", noise)), "noise.avi: cannot be opened"));
}

TEST(VideoReader, RefusesSoundAlone) {
  const TemporaryFolder folder;
  write_sound_file(folder.path() / "sound.mov");
  EXPECT_TRUE(holds(refusal_of([&] { VideoReader reader(folder.path() / "sound.mov"); }),
                    "sound.mov: has no pictures"));
}

TEST(VideoReader, RefusesPicturesWithoutLuma) {
  const TemporaryFolder folder;
  const auto refusal = [&](const char* codec, const char* format) {
    const fs::path path = folder.path() / "film.mkv";
    write_foreign_film(path,
                       {.codec = codec, .pixel_format = format, .stamps = even_stamps(5, 512)});
    return refusal_of([&] { VideoReader reader(path); });
  };
  EXPECT_TRUE(holds(refusal("ffv1", "bgr0"), "pixel format is bgr0"));
}

TEST(VideoReader, ReadsTheLumaOfManyFormats) {
  const TemporaryFolder folder;
  const std::vector<std::pair<const char*, const char*>> formats = {{"libx264", "yuv420p"},
                                                                    {"libx264", "yuv422p"},
                                                                    {"libx264", "yuvj444p"},
                                                                    {"libx264", "gray"},
                                                                    {"ffv1", "yuv410p"},
                                                                    {"ffv1", "yuva420p"},
                                                                    {"rawvideo", "yuyv422"},
                                                                    {"rawvideo", "uyvy422"},
                                                                    {"rawvideo", "nv12"}};
  for (const auto& [codec, format] : formats) {
    const fs::path path = folder.path() / "film.nut";
    write_foreign_film(path, {codec, format, even_stamps(20, 64)});
    const ReadFilm film = read_levels(path);
    ASSERT_EQ(film.levels.size(), 20U) << codec << format;
    for (int n = 0; n < 20; ++n) {
      EXPECT_EQ(film.levels[static_cast<std::size_t>(n)], picture_level(n)) << codec << format;
    }
  }
}

TEST(VideoReader, RoundsDeepLumaToEightBits) {
  const TemporaryFolder folder;
  const std::vector<std::pair<const char*, const char*>> formats = {{"ffv1", "yuv420p10le"},
                                                                    {"ffv1", "gray12le"},
                                                                    {"rawvideo", "yuv422p16be"},
                                                                    {"rawvideo", "gray16be"}};
  for (const auto& [codec, format] : formats) {
    const fs::path path = folder.path() / "film.nut";
    write_foreign_film(path, {codec, format, even_stamps(20, 64)});
    const ReadFilm film = read_levels(path);
    ASSERT_EQ(film.levels.size(), 20U) << codec << format;
    for (int n = 0; n < 20; ++n) {
      // The bits below count pictures: of ten, the upper half of four rounds up.
      const int steps = std::string(format).find("10") != std::string::npos   ? 4
                        : std::string(format).find("12") != std::string::npos ? 16
                                                                              : 256;
      const int up = n % steps >= steps / 2 ? 1 : 0;
      EXPECT_EQ(film.levels[static_cast<std::size_t>(n)], picture_level(n) + up) << format << n;
    }
  }
}

TEST(VideoReader, KeepsUnevenStampsAndTheirOrigin) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "film.mkv";
  const std::vector<std::int64_t> stamps = {500, 504, 508, 531, 535, 536, 600, 604};
  write_foreign_film(path, {.stamps = stamps, .ticks_per_s = 1000});
  const ReadFilm film = read_levels(path);
  ASSERT_EQ(film.stamps.size(), stamps.size());
  for (std::size_t n = 0; n < stamps.size(); ++n) {
    EXPECT_DOUBLE_EQ(film.stamps[n], static_cast<double>(stamps[n]) / 1000.0);
    EXPECT_EQ(film.levels[n], picture_level(static_cast<int>(n)));
  }
}

TEST(VideoReader, PutsStampsInOrderThatWereLostInReordering) {
  // Some programs cut films so that B pictures carry the stamps of their place in the file.
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "film.mp4";
  write_foreign_film(path, {.stamps = even_stamps(60, 512), .reordering_lost = true});
  const ReadFilm film = read_levels(path);
  ASSERT_EQ(film.stamps.size(), 60U);
  for (std::size_t n = 0; n < 60; ++n) {
    EXPECT_DOUBLE_EQ(film.stamps[n], static_cast<double>(n) / 30.0);
    EXPECT_EQ(film.levels[n], picture_level(static_cast<int>(n)));
  }
}

}  // namespace
}  // namespace twang::test
