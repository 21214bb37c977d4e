// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/png.hpp"
#include "capture/video_reader.hpp"
#include "capture/video_writer.hpp"
#include "tests/capture/foreign_film.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <iterator>
#include <random>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

Image noise_image(int width, int height, int channels, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> level(0, 255);
  Image image{width, height, channels, {}};
  image.pixels.resize(static_cast<std::size_t>(width * height * channels));
  for (auto& pixel : image.pixels) pixel = static_cast<std::uint8_t>(level(random));
  return image;
}

std::vector<std::uint8_t> pixels_of(const LumaFrame& frame) {
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < frame.height_px; ++y) {
    const std::uint8_t* row = frame.pixels + y * frame.stride;
    pixels.insert(pixels.end(), row, row + frame.width_px);
  }
  return pixels;
}

void write_noise_film(const fs::path& path, int frames, VideoWriterOptions options) {
  VideoWriter writer(path, 64, 48, options);
  for (int n = 0; n < frames; ++n) writer.write(noise_image(64, 48, 1, static_cast<unsigned>(n)));
  writer.finish();
}

class LosslessFilm : public ::testing::TestWithParam<const char*> {};

TEST_P(LosslessFilm, ReturnsEveryGreyLevelAndStamp) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / GetParam();
  constexpr int kFrames = 30;
  write_noise_film(path, kFrames, {.fps = 240.0, .crf = 0});
  VideoReader reader(path);
  EXPECT_EQ(reader.info().width_px, 64);
  EXPECT_EQ(reader.info().height_px, 48);
  EXPECT_EQ(reader.info().codec, "h264");
  EXPECT_EQ(reader.info().declared_frames, kFrames);
  ASSERT_TRUE(reader.info().declared_fps);
  EXPECT_DOUBLE_EQ(*reader.info().declared_fps, 240.0);
  for (int n = 0; n < kFrames; ++n) {
    const auto frame = reader.read();
    ASSERT_TRUE(frame) << n;
    EXPECT_EQ(pixels_of(*frame), noise_image(64, 48, 1, static_cast<unsigned>(n)).pixels) << n;
    // Stamps are whole ticks.
    EXPECT_NEAR(frame->stamp_s, n / 240.0, 0.5001 * reader.info().tick_s) << n;
    // Noise cannot be coded in fewer bytes than its entropy, over six bits a pixel.
    EXPECT_GT(frame->coded_bytes, 64 * 48 * 6 / 8) << n;
    EXPECT_NE(std::string("IPB").find(frame->coded_as), std::string::npos) << n;
  }
  EXPECT_FALSE(reader.read());
  EXPECT_FALSE(reader.read());  // and stays at the end
}

INSTANTIATE_TEST_SUITE_P(Containers,
                         LosslessFilm,
                         ::testing::Values("film.mp4", "film.mov", "film.mkv"),
                         [](const auto& film) {
                           return fs::path(film.param).extension().string().substr(1);
                         });

TEST(VideoWriter, KeepsOddRatesExactly) {
  const TemporaryFolder folder;
  for (const double fps : {22.674, 30000.0 / 1001.0, 959.94}) {
    const fs::path path = folder.path() / "rate.mp4";
    write_noise_film(path, 20, {.fps = fps, .crf = 30});
    VideoReader reader(path);
    for (int n = 0; n < 20; ++n) {
      const auto frame = reader.read();
      ASSERT_TRUE(frame);
      EXPECT_NEAR(frame->stamp_s, n / fps, 1e-9) << fps;  // the rate is a fraction, ticks fit it
    }
    EXPECT_NEAR(reader.info().declared_fps.value_or(0.0), fps, 1e-6 * fps);
  }
}

TEST(VideoWriter, WritesTheCaptureRateThatTheReaderFinds) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "slow.mp4";
  write_noise_film(path, 12, {.fps = 30.0, .crf = 30, .capture_fps_tag = 239.5});
  EXPECT_EQ(VideoReader(path).info().capture_fps_tag, 239.5);
  write_noise_film(path, 12, {.fps = 30.0, .crf = 30});
  EXPECT_EQ(VideoReader(path).info().capture_fps_tag, std::nullopt);
}

TEST(VideoWriter, TurnsColourIntoFullRangeLuma) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "colour.mkv";
  Image image{16, 16, 3, {}};
  for (int i = 0; i < 256; ++i) {
    const auto level = static_cast<std::uint8_t>(i);
    // The first row of each half: pure red; the others a grey of every level.
    if (i % 128 < 16) {
      image.pixels.insert(image.pixels.end(), {255, 0, 0});
    } else {
      image.pixels.insert(image.pixels.end(), {level, level, level});
    }
  }
  VideoWriter writer(path, 16, 16, {.fps = 10.0, .crf = 0});
  writer.write(image);
  writer.finish();
  VideoReader reader(path);
  const auto frame = reader.read();
  ASSERT_TRUE(frame);
  const auto luma = pixels_of(*frame);
  for (std::size_t i = 0; i < 256; ++i) {
    EXPECT_EQ(luma[i], i % 128 < 16 ? 76 : i);  // 0.299 x 255 = 76.2
  }
}

TEST(VideoWriter, TellsPlayersThatLevelsAreFullRange) {
  // Read back by FFmpeg itself: without the tag a player stretches 16..235 to black and white.
  const TemporaryFolder folder;
  for (const char* name : {"range.mp4", "range.mov", "range.mkv"}) {
    const fs::path path = folder.path() / name;
    write_noise_film(path, 3, {.fps = 10.0, .crf = 20});
    EXPECT_EQ(colour_range_of(path), "pc") << name;
  }
}

TEST(VideoWriter, PadsOddSizesByRepeatingTheEdge) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "odd.mp4";
  const Image image = noise_image(33, 21, 1, 5);
  VideoWriter writer(path, 33, 21, {.fps = 10.0, .crf = 0});
  writer.write(image);
  writer.finish();
  VideoReader reader(path);
  const auto frame = reader.read();
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->width_px, 34);
  ASSERT_EQ(frame->height_px, 22);
  for (int y = 0; y < 22; ++y) {
    for (int x = 0; x < 34; ++x) {
      const int source = std::min(y, 20) * 33 + std::min(x, 32);
      EXPECT_EQ(frame->pixels[y * frame->stride + x],
                image.pixels[static_cast<std::size_t>(source)]);
    }
  }
}

TEST(VideoWriter, LeavesNothingBehindUnlessFinished) {
  const TemporaryFolder folder;
  const fs::path path = folder.write("film.mp4", "the one before");
  {
    VideoWriter writer(path, 64, 48, {});
    writer.write(noise_image(64, 48, 1, 1));
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
  EXPECT_EQ(fs::file_size(path), 14U);  // "the one before"
}

TEST(VideoWriter, RefusesWhatItCannotWrite) {
  const TemporaryFolder folder;
  const auto refusal = [&](const char* name, VideoWriterOptions options) {
    return refusal_of([&] { VideoWriter(folder.path() / name, 64, 48, options); });
  };
  EXPECT_TRUE(holds(refusal("film.webm", {}), ".webm"));
  EXPECT_TRUE(holds(refusal("film", {}), ".mp4"));
  EXPECT_TRUE(holds(refusal("nowhere/film.mp4", {}), "nowhere"));
  EXPECT_TRUE(holds(refusal("film.mp4", {.fps = 0.0}), "fps is 0"));
  EXPECT_TRUE(holds(refusal("film.mp4", {.fps = std::nan("")}), "fps is nan"));
  EXPECT_TRUE(holds(refusal("film.mp4", {.crf = -1}), "crf is -1"));
  EXPECT_TRUE(holds(refusal("film.mp4", {.crf = 52}), "crf is 52"));
  EXPECT_TRUE(holds(refusal("film.mp4", {.capture_fps_tag = 0.0}), "capture_fps_tag is 0"));
  VideoWriter writer(folder.path() / "film.mp4", 64, 48, {});
  EXPECT_TRUE(holds(refusal_of([&] { writer.write(noise_image(64, 46, 1, 1)); }), "64 x 46"));
  EXPECT_TRUE(holds(refusal_of([&] { writer.finish(); }), "no pictures"));
}

TEST(Png, GreyImageReadsBackAsAFilmOfOneFrame) {
  const TemporaryFolder folder;
  const Image image = noise_image(37, 23, 1, 9);
  const auto bytes = encode_png(image);
  const fs::path path =
      folder.write("image.png", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  VideoReader reader(path);
  const auto frame = reader.read();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->width_px, 37);
  EXPECT_EQ(pixels_of(*frame), image.pixels);
  EXPECT_TRUE(std::isnan(frame->stamp_s));  // an image has no time
  EXPECT_EQ(reader.info().declared_fps, std::nullopt);
  EXPECT_FALSE(reader.read());
}

TEST(Png, ColourImageKeepsItsPixels) {
  const Image image = noise_image(37, 23, 3, 10);
  EXPECT_EQ(decode_png(encode_png(image), "rgb24"), image.pixels);
}

TEST(Png, RefusesAnImageThatIsNone) {
  (void)refusal_of([] { (void)encode_png({}); });
  (void)refusal_of([] { (void)encode_png({4, 4, 1, std::vector<std::uint8_t>(15)}); });
  (void)refusal_of([] { (void)encode_png({4, 4, 2, std::vector<std::uint8_t>(32)}); });
}

}  // namespace
}  // namespace twang::test
