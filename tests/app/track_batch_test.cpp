// SPDX-License-Identifier: GPL-3.0-or-later
// Many films in one call, as a lab works through a day's recordings.
#include "capture/render_film.hpp"
#include "capture/video_writer.hpp"
#include "core/atomic_file.hpp"
#include "core/trace_file.hpp"
#include "rigs/load_rig.hpp"
#include "tests/capture/filmed_rig.hpp"
#include "tests/capture/filmed_strip.hpp"
#include "tests/support/command.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

const std::string kStrip = std::string(TWANG_SOURCE_DIR) + "/rigs/strip.toml";

class TrackBatch : public testing::Test {
 protected:
  std::string film(const std::string& name) {
    const Rig rig = load_rig(kStrip, {.film = true});
    FilmOptions options;
    options.width_px = 480;
    options.height_px = 270;
    options.duration_s = 0.15;
    const StripMotion motion;
    const fs::path path = folder / name;
    fs::create_directories(path.parent_path());
    render_film(
        rig, [&](double time_s) { return motion.state_at(rig, time_s); }, path, options);
    return path.string();
  }
  [[nodiscard]] std::string out() const { return (folder / "out").string(); }
  [[nodiscard]] bool made(const std::string& name) const {
    return fs::exists(folder / "out" / name);
  }
  TemporaryFolder folder;
};

TEST_F(TrackBatch, WritesEachFilmsResultsUnderItsName) {
  const std::string a = film("a.mp4");
  const std::string b = film("b.mkv");
  const CommandOutcome outcome = run_twang({"track", kStrip, a, b, "--out", out(), "--json", "-"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* name : {"a.csv", "a.png", "b.csv", "b.png"}) EXPECT_TRUE(made(name)) << name;
  EXPECT_FALSE(made("a_overlay.mp4")) << "not asked for";
  EXPECT_EQ(read_trace_csv(folder / "out" / "b.csv").num_samples(), 36U);
  EXPECT_TRUE(read_file(folder / "out" / "a.png").starts_with("\x89PNG\r\n"));

  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json.at("format"), "twang-track/1");
  ASSERT_EQ(json.at("films").size(), 2U);
  const auto& first = json.at("films")[0];
  EXPECT_EQ(first.at("film"), a);
  EXPECT_EQ(first.at("time_base").at("frames"), 36);
  EXPECT_EQ(first.at("markers").size(), 5U);
  EXPECT_EQ(first.at("markers")[0].at("id"), "tip");
  EXPECT_EQ(first.at("markers")[0].at("frames_lost"), 0);
  EXPECT_GT(first.at("markers")[0].at("travel_mm").get<double>(), 1.0);
}

TEST_F(TrackBatch, TheSameFilmGivesTheSameTraceAlone) {
  const std::string a = film("a.mp4");
  ASSERT_EQ(run_twang({"track", kStrip, a, film("b.mp4"), "--out", out(), "--overlays"}).exit_code,
            0);
  EXPECT_TRUE(made("a_overlay.mp4"));
  const std::string alone = (folder / "alone.csv").string();
  const std::string sheet = (folder / "alone.png").string();
  ASSERT_EQ(run_twang({"track", kStrip, a, "-o", alone, "--sheet", sheet}).exit_code, 0);
  EXPECT_EQ(read_file(alone), read_file(folder / "out" / "a.csv"));
  EXPECT_EQ(read_file(sheet), read_file(folder / "out" / "a.png"));
}

TEST_F(TrackBatch, AFilmThatFailsLeavesTheOthersTheirTurn) {
  const std::string text = folder.write("text.mp4", "no film\n").string();
  const std::string good = film("good.mp4");
  const CommandOutcome outcome = run_twang(
      {"track", kStrip, text, good, "--out", out(), "--json", (folder / "sum.json").string()});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(made("good.csv"));
  EXPECT_FALSE(made("text.csv"));
  EXPECT_NE(outcome.err.find("text.mp4"), std::string::npos);
  EXPECT_NE(outcome.err.find("1 of 2 films could not be tracked"), std::string::npos)
      << outcome.err;
  // the failure was said before the other film's result
  EXPECT_LT(outcome.err.find("text.mp4"), outcome.err.find("good.mp4"));
  const auto json = nlohmann::json::parse(read_file(folder / "sum.json"));
  EXPECT_NE(json.at("films")[0].at("error").get<std::string>().find("text.mp4"), std::string::npos);
  EXPECT_FALSE(json.at("films")[1].contains("error"));
}

TEST_F(TrackBatch, AnInterruptKeepsTheFinishedFilms) {
  const std::string first = film("first.mp4");
  const std::string second = (folder / "second.mp4").string();
  {
    constexpr int kTimes = 50;  // long enough to be interrupted at leisure
    const std::vector<Image> images = read_film(first);
    VideoWriter writer(second, images[0].width_px, images[0].height_px, {.fps = 240.0});
    for (int i = 0; i < kTimes; ++i) {
      for (const Image& image : images) writer.write(image);
    }
    writer.finish();
  }
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    if (std::freopen((folder / "err").c_str(), "w", stderr) == nullptr) ::_exit(99);
    ::execl(TWANG_EXECUTABLE,
            "twang",
            "track",
            kStrip.c_str(),
            first.c_str(),
            second.c_str(),
            "--out",
            out().c_str(),
            "--overlays",
            static_cast<char*>(nullptr));
    ::_exit(99);
  }
  for (int i = 0; i < 3000 && !made("first.csv"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ::kill(child, SIGINT);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_TRUE(made("first.csv"));
  EXPECT_TRUE(made("first_overlay.mp4"));
  EXPECT_FALSE(made("second.csv"));
  EXPECT_NE(read_file(folder / "err").find("the results of 1 of 2 films are written"),
            std::string::npos);
  // three files of the first film and no half-made one of the second
  EXPECT_EQ(std::distance(fs::directory_iterator(out()), fs::directory_iterator()), 3);
}

TEST_F(TrackBatch, RefusesFilmsWhoseResultsWouldCollide) {
  const std::string a = film("monday/take.mp4");
  const std::string b = film("tuesday/take.mkv");
  const CommandOutcome outcome = run_twang({"track", kStrip, a, b, "--out", out()});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("would both write"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(TrackBatch, NeverWritesOverAFilm) {
  const std::string a = film("take.mp4");
  const std::string overlay = film("take_overlay.mp4");
  const CommandOutcome outcome =
      run_twang({"track", kStrip, a, overlay, "--out", folder.path().string(), "--overlays"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("take_overlay.mp4 would be written over"), std::string::npos)
      << outcome.err;
  EXPECT_EQ(run_twang({"track", kStrip, a, "-o", a}).exit_code, 2);
  EXPECT_GT(fs::file_size(a), 1000U);
}

}  // namespace
}  // namespace twang::test
