// SPDX-License-Identifier: GPL-3.0-or-later
// Films of camcorders: pixels that are not square, rows of two moments; made with ffmpeg.
#include "capture/track_markers.hpp"
#include "capture/video_reader.hpp"
#include "tests/capture/filmed_strip.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

bool told(const TrackResult& result, Severity severity, const std::string& part) {
  return std::any_of(result.notes.begin(), result.notes.end(), [&](const Note& note) {
    return note.severity == severity && holds(note.text, part);
  });
}

class PictureShape : public ::testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    if (std::system("command -v ffmpeg > /dev/null 2>&1") != 0) GTEST_SKIP() << "needs ffmpeg";
  }
  /// A strip swinging by 3 mm, in square pixels and without loss.
  fs::path film(const Rig& rig) {
    FilmOptions options;
    options.width_px = 640;
    options.height_px = 360;
    options.duration_s = 0.25;
    options.crf = 0;
    const StripMotion motion;
    const fs::path path = m_folder.path() / "plain.mkv";
    (void)render_film(
        rig, [&](double time_s) { return motion.state_at(rig, time_s); }, path, options);
    return path;
  }
  /// What ffmpeg makes of a film with these arguments.
  fs::path remade(const fs::path& from, const std::string& arguments, const std::string& name) {
    const fs::path to = m_folder.path() / name;
    const std::string command = "ffmpeg -v error -y -i '" + from.string() + "' " + arguments +
                                " '" + to.string() + "' < /dev/null";
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    return to;
  }
  TemporaryFolder m_folder;
};

constexpr const char* kSqueezed = "-vf scale=480:360:flags=area,setsar=4/3 -c:v libx264 -qp 0";

TEST_P(PictureShape, OfSqueezedPixelsGivesTheSameMillimetres) {
  const Rig rig = strip_rig(GetParam());
  const fs::path square = film(rig);
  const fs::path squeezed = remade(square, kSqueezed, "squeezed.mkv");
  EXPECT_NEAR(VideoReader(squeezed).info().pixel_aspect, 4.0 / 3.0, 1e-6);  // of a fraction
  EXPECT_EQ(VideoReader(square).info().pixel_aspect, 1.0);

  const TrackResult plain = track_markers(rig, square);
  const TrackResult result = track_markers(rig, squeezed);
  EXPECT_TRUE(told(result, Severity::Remark, "1.3333 times as wide as high: 480 x 360 px"));
  EXPECT_FALSE(told(plain, Severity::Remark, "times as wide as high"));
  EXPECT_NEAR(result.mm_per_px / plain.mm_per_px, 1.0, 5e-3);
  const auto& a = plain.trace.find("observable_mm")->values;
  const auto& b = result.trace.find("observable_mm")->values;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t n = 0; n < a.size(); ++n) {
    // of an amplitude of 2.8 mm: a tenth of a pixel, and half a per cent of scale; a quarter of the
    // amplitude were the pixels taken for square
    EXPECT_NEAR(a[n], b[n], 0.1 * plain.mm_per_px + 5e-3 * std::abs(a[n])) << n;
  }
}

INSTANTIATE_TEST_SUITE_P(FixedMarkers, PictureShape, ::testing::Values(4, 3, 2));

using FilmedShape = PictureShape;

TEST_F(FilmedShape, OfATurnedFilmHasItsPixelsTurned) {
  const fs::path squeezed = remade(film(strip_rig()), kSqueezed, "squeezed.mp4");
  const fs::path turned = remade(squeezed, "-c copy -metadata:s:v:0 rotate=90", "turned.mp4");
  const VideoInfo info = VideoReader(turned).info();
  EXPECT_EQ(info.width_px, 360);
  EXPECT_NEAR(info.pixel_aspect, 0.75, 1e-6);  // of a fraction
}

TEST_F(FilmedShape, OfTwoMomentsIsWarnedOf) {
  const Rig rig = strip_rig();
  const fs::path progressive = film(rig);
  EXPECT_FALSE(told(track_markers(rig, progressive), Severity::Warning, "interlaced"));
  const std::string woven = "-vf tinterlace=interleave_top -flags +ilme+ildct ";
  for (const auto& [codec, name] : {std::pair{"-c:v libx264 -x264-params tff=1", "h264.mp4"},
                                    {"-c:v mpeg2video -q:v 2", "mpeg2.mkv"}}) {
    Rig slower = rig;
    slower.camera->capture_fps = 120.0;
    const TrackResult result = track_markers(slower, remade(progressive, woven + codec, name));
    EXPECT_TRUE(told(result, Severity::Warning, "The film is interlaced")) << name;
  }
}

}  // namespace
}  // namespace twang::test
