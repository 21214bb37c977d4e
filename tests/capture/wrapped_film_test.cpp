// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/track_markers.hpp"
#include "capture/video_reader.hpp"
#include "capture/video_writer.hpp"
#include "tests/capture/filmed_strip.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

constexpr double kFps = 240.0;
constexpr int kFrames = 36;

bool ffmpeg_is_there() { return std::system("ffmpeg -version >/dev/null 2>&1") == 0; }

/// Runs ffmpeg on a film; what it is to do stands between input and output.
void convert(const fs::path& from, const std::string& what, const fs::path& to) {
  const std::string command = "ffmpeg -nostdin -v error -y -i '" + from.string() + "' " + what +
                              " '" + to.string() + "' >/dev/null 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
}

/// One film, rendered once without loss: the original of every other.
class Original {
 public:
  Original() : m_rig(strip_rig()) {
    m_rig.camera->capture_fps.reset();
    FilmOptions options;
    options.width_px = 400;
    options.height_px = 240;
    options.fps = kFps;
    options.duration_s = kFrames / kFps;
    options.noise = 1.0;
    options.crf = 0;
    const StripMotion motion{.release_s = 0.01};
    (void)render_film(
        m_rig, [&](double time_s) { return motion.state_at(m_rig, time_s); }, path(), options);
    m_tracked = track_markers(m_rig, path());
  }
  [[nodiscard]] fs::path path() const { return m_folder.path() / "original.mkv"; }
  [[nodiscard]] const fs::path& folder() const { return m_folder.path(); }
  [[nodiscard]] const Rig& rig() const { return m_rig; }
  [[nodiscard]] const TrackResult& tracked() const { return m_tracked; }

 private:
  TemporaryFolder m_folder;
  Rig m_rig;
  TrackResult m_tracked;
};

const Original& original() {
  static const Original kOriginal;
  return kOriginal;
}

void expect_same_positions(const TrackResult& tracked) {
  const TrackResult& first = original().tracked();
  ASSERT_EQ(tracked.tracks.size(), first.tracks.size());
  double sum = 0.0;
  int count = 0;
  for (std::size_t m = 0; m < first.tracks.size(); ++m) {
    const auto& before = first.tracks[m].position_px;
    const auto& after = tracked.tracks[m].position_px;
    ASSERT_EQ(after.size(), before.size()) << first.tracks[m].id;
    for (std::size_t n = 0; n < before.size(); ++n) {
      ASSERT_TRUE(before[n].allFinite() && after[n].allFinite()) << first.tracks[m].id << " " << n;
      sum += (after[n] - before[n]).squaredNorm();
      count += 2;
    }
  }
  ::testing::Test::RecordProperty("rms_px", std::to_string(std::sqrt(sum / count)));
  EXPECT_LE(std::sqrt(sum / count), 0.03);  // what is asked of a film at high quality [px]
}

void expect_even_time(const TrackResult& tracked) {
  const auto& time_s = tracked.trace.time_s;
  ASSERT_EQ(time_s.size(), static_cast<std::size_t>(kFrames));
  double worst_s = 0.0;
  for (std::size_t n = 0; n < time_s.size(); ++n) {
    worst_s = std::max(worst_s, std::abs(time_s[n] - static_cast<double>(n) / kFps));
    EXPECT_NEAR(time_s[n], static_cast<double>(n) / kFps, 1e-6) << n;
  }
  ::testing::Test::RecordProperty("worst_stamp_s", std::to_string(worst_s));
}

struct Wrapping {
  const char* name;
  const char* file;
  const char* how;
};
void PrintTo(const Wrapping& wrapping, std::ostream* out) { *out << wrapping.name; }

class WrappedFilm : public ::testing::TestWithParam<Wrapping> {
 protected:
  void SetUp() override {
    if (!ffmpeg_is_there()) GTEST_SKIP() << "ffmpeg is not installed";
  }
};

TEST_P(WrappedFilm, ComesOutEqual) {
  const fs::path path = original().folder() / GetParam().file;
  ASSERT_NO_FATAL_FAILURE(convert(original().path(), GetParam().how, path));
  const TrackResult tracked = track_markers(original().rig(), path);
  EXPECT_TRUE(tracked.time_base.even);
  EXPECT_EQ(tracked.time_base.gaps, 0);
  EXPECT_EQ(tracked.time_base.kind, TimeBaseKind::Constant);
  expect_even_time(tracked);
  expect_same_positions(tracked);
}

INSTANTIATE_TEST_SUITE_P(
    All,
    WrappedFilm,
    ::testing::Values(
        Wrapping{"H264Mp4", "h264.mp4", "-c:v libx264 -crf 8"},
        Wrapping{"H264Mov", "h264.mov", "-c:v libx264 -crf 8"},
        Wrapping{"H264Mkv", "h264.mkv", "-c:v libx264 -crf 8"},
        Wrapping{"H264Avi", "h264.avi", "-c:v libx264 -crf 8"},
        Wrapping{"H264AviWithoutReordering", "plain.avi", "-c:v libx264 -crf 8 -bf 0"},
        Wrapping{"H264Ts", "h264.ts", "-c:v libx264 -crf 8"},
        Wrapping{"H264LimitedRange",
                 "limited.mp4",
                 "-vf scale=in_range=full:out_range=limited -pix_fmt yuv420p -c:v libx264 -crf 6"},
        Wrapping{"H264InTicksOf600", "apple.mov", "-c:v libx264 -crf 8 -video_track_timescale 600"},
        Wrapping{
            "H264CopiedFromMilliseconds", "copied.mp4", "-c:v copy -video_track_timescale 16000"},
        Wrapping{"HevcMp4", "hevc.mp4", "-c:v libx265 -crf 6 -x265-params log-level=none"},
        Wrapping{
            "HevcMov", "hevc.mov", "-c:v libx265 -crf 6 -tag:v hvc1 -x265-params log-level=none"},
        Wrapping{"HevcMkv", "hevc.mkv", "-c:v libx265 -crf 6 -x265-params log-level=none"},
        Wrapping{"HevcTenBits",
                 "hevc10.mp4",
                 "-c:v libx265 -crf 6 -pix_fmt yuv420p10le -x265-params log-level=none"},
        Wrapping{"MjpegMov", "mjpeg.mov", "-c:v mjpeg -q:v 2"},
        Wrapping{"MjpegMkv", "mjpeg.mkv", "-c:v mjpeg -q:v 2"},
        Wrapping{"MjpegAvi", "mjpeg.avi", "-c:v mjpeg -q:v 2"}),
    [](const auto& wrapping) { return std::string(wrapping.param.name); });

struct Turn {
  const char* name;
  const char* pixels;   ///< ffmpeg's filter that turns the stored picture
  const char* tag_deg;  ///< as ffmpeg takes it, against the clock
  int turn_deg;         ///< clockwise, by which a player turns it back
};
void PrintTo(const Turn& turn, std::ostream* out) { *out << turn.name; }

class TurnedFilm : public ::testing::TestWithParam<Turn> {
 protected:
  void SetUp() override {
    if (!ffmpeg_is_there()) GTEST_SKIP() << "ffmpeg is not installed";
  }
};

TEST_P(TurnedFilm, IsHandedOnAsAPlayerShowsIt) {
  const fs::path folder = original().folder();
  const std::string file = std::string(GetParam().name) + ".mp4";
  ASSERT_NO_FATAL_FAILURE(convert(original().path(),
                                  std::string("-c:v libx264 -crf 8 -vf ") + GetParam().pixels,
                                  folder / "stored.mp4"));
  ASSERT_NO_FATAL_FAILURE(
      convert(folder / "stored.mp4",
              std::string("-c copy -metadata:s:v:0 rotate=") + GetParam().tag_deg,
              folder / file));
  const VideoReader reader(folder / file);
  EXPECT_EQ(reader.info().width_px, 400);
  EXPECT_EQ(reader.info().height_px, 240);
  EXPECT_EQ(reader.info().rotation_deg, GetParam().turn_deg);
  const TrackResult tracked = track_markers(original().rig(), folder / file);
  expect_even_time(tracked);
  expect_same_positions(tracked);
}

INSTANTIATE_TEST_SUITE_P(All,
                         TurnedFilm,
                         ::testing::Values(Turn{"Quarter", "transpose=cclock", "270", 90},
                                           Turn{"Half", "hflip,vflip", "180", 180},
                                           Turn{"ThreeQuarters", "transpose=clock", "90", 270}),
                         [](const auto& turn) { return std::string(turn.param.name); });

/// Films whose time is not plainly theirs.
class RetimedFilm : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!ffmpeg_is_there()) GTEST_SKIP() << "ffmpeg is not installed";
  }
  static fs::path retimed(const std::string& file, const std::string& how) {
    const fs::path path = original().folder() / file;
    convert(original().path(), how, path);
    return path;
  }
};

TEST_F(RetimedFilm, SlowMotionComesOutEqualByTagRigOrOption) {
  const std::string slow = "-vf setpts=8*PTS -r 30 -c:v libx264 -crf 8 ";
  for (const char* extension : {"mp4", "mov"}) {
    const fs::path tagged =
        retimed(std::string("tagged.") + extension,
                slow + "-movflags use_metadata_tags -metadata com.android.capture.fps=240.000000");
    const TrackResult tracked = track_markers(original().rig(), tagged);
    EXPECT_EQ(tracked.time_base.source, "tag");
    EXPECT_EQ(tracked.time_base.kind, TimeBaseKind::SlowMotion);
    expect_even_time(tracked);
    expect_same_positions(tracked);
  }
  const fs::path untagged = retimed("untagged.mp4", slow);
  EXPECT_EQ(track_markers(original().rig(), untagged).time_base.capture_fps, 30.0);
  Rig rig = original().rig();
  rig.camera->capture_fps = kFps;
  const TrackResult by_rig = track_markers(rig, untagged);
  EXPECT_EQ(by_rig.time_base.source, "rig");
  expect_even_time(by_rig);
  TrackOptions options;
  options.capture_fps = kFps;
  expect_even_time(track_markers(original().rig(), untagged, options));
}

TEST_F(RetimedFilm, VariableRateIsRightToTheTick) {
  constexpr double kTick = 1.0 / 90000.0;
  for (const char* extension : {"mp4", "mov"}) {
    const fs::path path = retimed(std::string("variable.") + extension,
                                  "-vf \"settb=1/90000,setpts='(N/240+0.0006*sin(2.1*N))/TB'\" "
                                  "-fps_mode passthrough -enc_time_base 1/90000 "
                                  "-video_track_timescale 90000 -c:v libx264 -crf 8");
    const TrackResult tracked = track_markers(original().rig(), path);
    EXPECT_EQ(tracked.time_base.kind, TimeBaseKind::Variable);
    EXPECT_EQ(tracked.time_base.tick_s, kTick);
    const auto& time_s = tracked.trace.time_s;
    ASSERT_EQ(time_s.size(), static_cast<std::size_t>(kFrames));
    for (std::size_t n = 0; n < time_s.size(); ++n) {
      const auto number = static_cast<double>(n);
      // The filter cuts off what is beyond a tick, of this stamp and of the first.
      EXPECT_NEAR(time_s[n], number / kFps + 0.0006 * std::sin(2.1 * number), 1.001 * kTick) << n;
    }
    expect_same_positions(tracked);
  }
}

TEST_F(RetimedFilm, DroppedFramesAreMissedAndTheOthersKeepTheirTime) {
  for (const char* extension : {"mp4", "mkv", "avi"}) {
    const fs::path path = retimed(
        std::string("dropped.") + extension,
        "-vf \"select='not(eq(n,10)+eq(n,11)+eq(n,25))'\" -fps_mode passthrough -c:v mjpeg -q:v 2");
    const TrackResult tracked = track_markers(original().rig(), path);
    EXPECT_EQ(tracked.time_base.gaps, 3) << extension;
    EXPECT_TRUE(tracked.time_base.even) << extension;
    const auto& time_s = tracked.trace.time_s;
    ASSERT_EQ(time_s.size(), static_cast<std::size_t>(kFrames - 3)) << extension;
    for (std::size_t i = 0; i < time_s.size(); ++i) {
      const std::size_t n = i < 10 ? i : i < 23 ? i + 2 : i + 3;
      EXPECT_NEAR(time_s[i], static_cast<double>(n) / kFps, 1e-6) << extension << " " << i;
    }
  }
}

TEST(TrackWithLight, TellsTheSlowMotionThatTheFileConceals) {
  // The original with a light of 40 Hz painted in, stored as if it had been filmed at half the
  // rate.
  const fs::path path = original().folder() / "light.mkv";
  {
    VideoReader reader(original().path());
    VideoWriter writer(path, 400, 240, {.fps = kFps / 2.0, .crf = 4});
    for (int n = 0; n < kFrames; ++n) {
      const auto frame = reader.read();
      ASSERT_TRUE(frame);
      Image image{400, 240, 1, {}};
      for (int y = 0; y < 240; ++y) {
        const std::uint8_t* row = frame->pixels + y * frame->stride;
        image.pixels.insert(image.pixels.end(), row, row + 400);
      }
      const bool bright = std::fmod(40.0 * n / kFps + 0.05, 1.0) < 0.5;
      for (int y = 2; y < 12; ++y) {
        std::fill_n(image.pixels.begin() + y * 400 + 2, 10, bright ? 250 : 90);
      }
      writer.write(image);
    }
    writer.finish();
  }
  TrackOptions options;
  options.clock = BlinkingLight{3.0, 3.0, 8.0, 8.0, 40.0};
  const TrackResult tracked = track_markers(original().rig(), path, options);
  ASSERT_TRUE(tracked.clock && tracked.clock->found);
  // Six periods of six frames each: the rate to a part of a frame in thirty-six.
  EXPECT_NEAR(tracked.clock->deviation_rel, -0.5, 0.01);
  EXPECT_FALSE(tracked.clock->warning.empty());
  EXPECT_EQ(tracked.time_base.capture_fps, kFps / 2.0);  // said, not done
  options.clock_correct = true;
  const TrackResult corrected = track_markers(original().rig(), path, options);
  EXPECT_TRUE(corrected.clock->corrected);
  EXPECT_EQ(corrected.time_base.source, "clock");
  EXPECT_NEAR(corrected.trace.time_s.back(), (kFrames - 1) / kFps, 0.02 * kFrames / kFps);
  options.clock->x_px = 395.0;
  EXPECT_TRUE(holds(refusal_of([&] { (void)track_markers(original().rig(), path, options); }),
                    "the picture of"));
  options.clock.reset();
  EXPECT_TRUE(holds(refusal_of([&] { options.check(); }), "clock_correct"));
}

}  // namespace
}  // namespace twang::test
