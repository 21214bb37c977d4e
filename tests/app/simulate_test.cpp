// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/atomic_file.hpp"
#include "tests/simulate/sample_scene.hpp"
#include "tests/support/command.hpp"
#include "tests/support/expect_refusal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace twang {
namespace {

namespace fs = std::filesystem;
using test::holds;
using test::run_twang;
using test::SampleScene;

/// Long enough to be killed in the middle.
std::string long_scene() {
  std::string text = test::with(test::kStripScene, "duration_s = 4e-3", "duration_s = 0.04");
  text = test::with(text, "every_s = 5e-4", "every_s = 2e-3");
  return test::with(text, "dx_mm = 5.0", "dx_mm = 2.0");
}

/// Starts `twang simulate`, sends it `signal` (0: none) once `wait` is over, and tells its exit
/// status.
int simulate_until(const SampleScene& sample,
                   const fs::path& out,
                   bool resume,
                   int signal,
                   const std::function<void()>& wait) {
  const pid_t child = ::fork();
  if (child == 0) {
    const int null = ::open("/dev/null", O_WRONLY);
    ::dup2(null, STDOUT_FILENO);
    ::dup2(null, STDERR_FILENO);
    std::vector<std::string> words = {
        TWANG_EXECUTABLE, "simulate", sample.scene, "--out", out, "--threads", "1"};
    if (resume) words.emplace_back("--resume");
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    ::execv(TWANG_EXECUTABLE, arguments.data());
    ::_exit(127);
  }
  wait();
  ::kill(child, signal);
  int status = 0;
  ::waitpid(child, &status, 0);
  return status;
}

std::string state_in(const fs::path& out) {
  const auto summary = nlohmann::json::parse(read_file(out / "summary.json"));
  EXPECT_TRUE(summary.at("completed").get<bool>());
  return summary.at("state_sha256").get<std::string>();
}

TEST(Simulate, KilledAtTwentyMomentsAndResumedEndsInTheSameBits) {
  const SampleScene sample(long_scene());
  const fs::path whole = sample.folder / "whole";
  ASSERT_EQ(run_twang({"simulate", sample.scene, "--out", whole, "--threads", "1"}).exit_code, 0);
  std::mt19937 random(7);
  std::uniform_int_distribution<int> delay_ms(20, 300);
  constexpr int kWanted = 20;
  int kills = 0;
  int runs = 0;
  int resumed = 0;
  while (kills < kWanted) {
    const fs::path killed = sample.folder / ("killed_" + std::to_string(++runs));
    for (bool ended = false; !ended;) {
      const bool resume = fs::exists(killed / "checkpoint.bin");
      resumed += resume ? 1 : 0;
      // the moment is anywhere, the start and the writing of files included
      const auto wait = [&] {
        if (kills < kWanted)
          std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms(random)));
      };
      const int status =
          simulate_until(sample, killed, resume, kills < kWanted ? SIGKILL : 0, wait);
      ended = WIFEXITED(status);
      if (ended) {
        ASSERT_EQ(WEXITSTATUS(status), 0);
      }
      kills += ended ? 0 : 1;
    }
    EXPECT_EQ(state_in(killed), state_in(whole));
    for (const char* name : {"energy.csv", "motion.csv", "probes.csv", "frames.pvd"})
      EXPECT_EQ(read_file(killed / name), read_file(whole / name)) << name;
  }
  fmt::print("killed {} times in {} runs, resumed {} times\n", kills, runs, resumed);
  EXPECT_GE(resumed, runs);
}

TEST(Simulate, InterruptedEndsWith130AndCanBeResumed) {
  const SampleScene sample(long_scene());
  const fs::path out = sample.folder / "out";
  const auto begun = [&] {
    for (int i = 0; i < 1000 && !fs::exists(out / "energy.csv"); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  };
  const int status = simulate_until(sample, out, false, SIGINT, begun);
  ASSERT_TRUE(WIFEXITED(status));
  ASSERT_EQ(WEXITSTATUS(status), 130);
  const test::CommandOutcome rest =
      run_twang({"simulate", sample.scene, "--out", out, "--threads", "1", "--resume"});
  EXPECT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_TRUE(holds(rest.out, "resumed at"));
}

TEST(Simulate, FailuresAndRefusalsHaveTheirExitCodes) {
  const SampleScene sample(test::with(
      test::kStripScene, "displacement_mm = [0.0, 0.0, -4.0]", "force_n = [-1e9, 0, 0]"));
  const auto run = [&](const fs::path& scene) {
    return run_twang({"simulate", scene, "--out", sample.folder / "out"});
  };
  const test::CommandOutcome failed = run(sample.scene);
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_TRUE(holds(failed.err, "cannot be loaded"));
  const test::CommandOutcome refused = run(sample.folder / "none.toml");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_TRUE(holds(refused.err, "none.toml: no such file"));
  const test::CommandOutcome threads =
      run_twang({"simulate", sample.scene, "--out", sample.folder / "out", "--threads", "-1"});
  EXPECT_EQ(threads.exit_code, 2);
}

}  // namespace
}  // namespace twang
