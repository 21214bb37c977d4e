// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/run_scene.hpp"

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/trace_file.hpp"
#include "tests/simulate/sample_scene.hpp"
#include "tests/support/expect_refusal.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

namespace twang {
namespace {

namespace fs = std::filesystem;
using test::holds;
using test::kStripScene;
using test::refusal_of;
using test::SampleScene;
using test::with;

SceneSummary run_in(const SampleScene& sample,
                    const fs::path& out,
                    bool resume = false,
                    int threads = 1) {
  SceneOptions options;
  options.folder = out;
  options.resume = resume;
  options.threads = threads;
  return run_scene(load_scene(sample.scene), options);
}

/// Stops after so many steps; whether it was stopped.
bool run_until(const SampleScene& sample, const fs::path& out, double steps, bool resume) {
  SceneOptions options;
  options.folder = out;
  options.resume = resume;
  options.threads = 1;
  options.progress = [steps](const Progress& p) {
    return p.stage != "simulating" || p.done < steps;
  };
  try {
    static_cast<void>(run_scene(load_scene(sample.scene), options));
  } catch (const Cancelled& stop) {
    EXPECT_TRUE(holds(stop.what(), "--resume"));
    return true;
  }
  return false;
}

const std::vector<double>& column(const Trace& trace, const std::string& name) {
  const Channel* channel = trace.find(name);
  EXPECT_NE(channel, nullptr) << name;
  static const std::vector<double> kNone;
  return channel != nullptr ? channel->values : kNone;
}

TEST(RunScene, WritesWhatTheContractSays) {
  const SampleScene sample;
  const fs::path out = sample.folder / "out";
  const SceneSummary summary = run_in(sample, out);
  EXPECT_TRUE(summary.usable()) << summary.run.message;
  EXPECT_EQ(summary.run.steps, 40);
  const Trace energy = read_trace_csv(out / "energy.csv");
  EXPECT_EQ(energy.num_samples(), 41U);
  EXPECT_EQ(energy.channels.size(), 14U);
  const Trace probes = read_trace_csv(out / "probes.csv");
  ASSERT_EQ(probes.num_samples(), 9U);
  EXPECT_DOUBLE_EQ(probes.time_s[1], 5e-4);
  const Trace motion = read_trace_csv(out / "motion.csv");
  EXPECT_EQ(motion.num_samples(), 9U);
  EXPECT_EQ(motion.channels.size(), 10U);
  EXPECT_EQ(motion.channels[0].name, "strip.x_mm");
  // Pressed by 4 mm at x = 40 mm, the marker at 38 mm a little less, and let go.
  const std::vector<double>& z = column(probes, "strip.tip.z_mm");
  EXPECT_LT(z.front(), 2.0 - 3.5);
  EXPECT_GT(z.front(), 2.0 - 4.0);
  EXPECT_GT(z.back(), z.front() + 2.0);
  // Nothing moves before the release, and nothing is lost.
  const std::vector<double>& kinetic = column(energy, "kinetic_j");
  EXPECT_LT(kinetic[2], 1e-9 * kinetic[20]);
  EXPECT_GT(kinetic[3], 1e-3 * kinetic[20]);
  EXPECT_LT(summary.remainder_rel, 0.01);
  // Frames with their times, and what ParaView shows of them.
  const std::string pvd = read_file(out / "frames.pvd");
  EXPECT_TRUE(
      holds(pvd, "timestep=\"0.004\" part=\"0\" name=\"strip\" file=\"frames/strip_000008"));
  const std::string vtu = read_file(out / "frames" / "strip_000008.vtu");
  for (const char* array :
       {"displacement_m", "velocity_m_s", "stress_pa", "von_mises_pa", "material"})
    EXPECT_TRUE(holds(vtu.substr(0, 3000), std::string("Name=\"") + array + "\""));
  EXPECT_TRUE(holds(read_file(out / "summary.json"), "\"wall_s_per_step\""));
}

TEST(RunScene, FreeBodyFliesAndTurnsAsARigidOne) {
  std::string text = with(kStripScene, "clamped = true", R"(clamped = false
position_mm = [100.0, 0.0, 0.0]
rotation_deg = [90.0, 0.0, 0.0]
velocity_m_s = [1.0, 0.0, 2.0]
spin_rad_s = [50.0, 0.0, 0.0])");
  text = text.substr(0, text.find("[[load]]")) + "[output]\nevery_s = 1e-3\n";
  const SampleScene sample(text);
  const fs::path out = sample.folder / "out";
  ASSERT_TRUE(run_in(sample, out).usable());
  const Trace motion = read_trace_csv(out / "motion.csv");
  const double t = motion.time_s.back();
  ASSERT_DOUBLE_EQ(t, 4e-3);
  // The centre (20, 5, 2) mm of the rig stands at (120, -2, 5) mm at first; a constant acceleration
  // is exact for the rule, residuals are 1e-8 of the forces.
  EXPECT_NEAR(column(motion, "strip.x_mm").back(), 120.0 + 1e3 * t, 1e-6);
  EXPECT_NEAR(column(motion, "strip.y_mm").back(), -2.0, 1e-6);
  EXPECT_NEAR(column(motion, "strip.z_mm").back(), 5.0 + 2e3 * t - 0.5 * 9810.0 * t * t, 1e-6);
  EXPECT_NEAR(column(motion, "strip.vz_m_s").back(), 2.0 - 9.81 * t, 1e-6);
  // About its long axis, a principal one: 90° and 50 rad/s. It spreads as it is let go spinning,
  // and the rule's period is longer by (spin h)² / 12 = 2e-6.
  const double half = 0.5 * std::atan2(1.0, 0.0) + 0.5 * 50.0 * t;
  EXPECT_NEAR(column(motion, "strip.qw").back(), std::cos(half), 1e-4);
  EXPECT_NEAR(column(motion, "strip.qx").back(), std::sin(half), 1e-4);
  EXPECT_NEAR(column(motion, "strip.qy").back(), 0.0, 1e-6);
  const Trace energy = read_trace_csv(out / "energy.csv");
  const std::vector<double>& lx = column(energy, "lx_kg_m2_s");
  // Gravity turns the flight about the origin: y m g t. The rest is kept but for
  // the waves that the sudden spin sends through the strip, which these steps do not resolve.
  const double torque = -2e-3 * (1180.0 * 40.0 * 10.0 * 4.0 * 1e-9) * -9.81;
  EXPECT_NEAR(lx.back() - lx.front(), torque * t, 1e-3 * std::abs(lx.front()));
}

TEST(RunScene, ResumedRunsEndInTheSameBits) {
  for (const char* scheme : {"\"newmark\"", "\"bdf2\""}) {
    const SampleScene sample(with(kStripScene, "\"newmark\"", scheme));
    const fs::path whole = sample.folder / "whole";
    const SceneSummary reference = run_in(sample, whole);
    const fs::path parts = sample.folder / "parts";
    ASSERT_TRUE(run_until(sample, parts, 1.0, false));
    for (const double steps : {2.0, 7.0, 8.0, 31.0})
      ASSERT_TRUE(run_until(sample, parts, steps, true));
    const SceneSummary summary = run_in(sample, parts, true);
    EXPECT_EQ(summary.resumed_at_step, 31);
    EXPECT_EQ(summary.state_sha256, reference.state_sha256);
    for (const char* name :
         {"energy.csv", "motion.csv", "probes.csv", "frames.pvd", "frames/strip_000008.vtu"})
      EXPECT_EQ(read_file(parts / name), read_file(whole / name)) << name;
  }
}

TEST(RunScene, SeveralLoadsAreHeldAndLetGoEachInItsTimeAndResume) {
  // One bends the tip and goes at 1 ms; one holds the middle aside until 3 ms; one grows and pulls.
  std::string text = with(kStripScene, "release_s = 2e-4", "release_s = 1e-3");
  text = with(text, "[[probe]]", R"([[load]]
body = "strip"
at_mm = [38.0, 0.0, 2.0]
displacement_mm = [0.0, 0.5, 0.0]
release_s = 3e-3
[[load]]
body = "strip"
marker = "tip"
force_n = [0.2, 0.0, 0.0]
ramp_s = 1e-3
release_s = 2e-3
[[probe]])");
  text = with(text, "every_s = 5e-4", "every_s = 1e-4");
  const SampleScene sample(text);
  const fs::path whole = sample.folder / "whole";
  const SceneSummary reference = run_in(sample, whole);
  ASSERT_TRUE(reference.usable()) << reference.run.message;
  EXPECT_LT(reference.remainder_rel, 0.01);
  const Trace probes = read_trace_csv(whole / "probes.csv");
  const std::vector<double>& y = column(probes, "strip.tip.y_mm");
  const std::vector<double>& z = column(probes, "strip.tip.z_mm");
  for (int i = 0; i <= 30; ++i)  // held at the marker: where it was told to be, to round-off
    EXPECT_NEAR(y[static_cast<std::size_t>(i)], 0.5, 1e-9);
  EXPECT_LT(y[35], 0.499);
  EXPECT_NEAR(z[10], z[0], 0.02);  // of 4 mm; the growing force moves it a little
  EXPECT_GT(z[15], z[0] + 0.05);
  const fs::path parts = sample.folder / "parts";
  ASSERT_TRUE(run_until(sample, parts, 4.0, false));
  for (const double steps : {9.0, 18.0, 29.0}) ASSERT_TRUE(run_until(sample, parts, steps, true));
  EXPECT_EQ(run_in(sample, parts, true).state_sha256, reference.state_sha256);
}

TEST(RunScene, TwoThreadsGoWhereOneGoes) {
  // Fine enough for work to be shared: 40 x 10 x 4 cells.
  for (const std::string solver : {"factor", "multigrid"}) {
    const SampleScene sample(
        with(with(kStripScene, "dx_mm = 5.0", "dx_mm = 1.0\nsolver = \"" + solver + "\""),
             "every_s = 5e-4",
             "every_s = 1e-4"));
    ASSERT_TRUE(run_in(sample, sample.folder / "one").usable());
    ASSERT_TRUE(run_in(sample, sample.folder / "two", false, 2).usable());
    const Trace one = read_trace_csv(sample.folder / "one" / "probes.csv");
    const Trace two = read_trace_csv(sample.folder / "two" / "probes.csv");
    const auto& z = column(one, "strip.tip.z_mm");
    const auto& other = column(two, "strip.tip.z_mm");
    ASSERT_EQ(z.size(), 41U);
    ASSERT_EQ(other.size(), z.size());
    double apart = 0.0;
    for (std::size_t i = 0; i < z.size(); ++i) apart = std::max(apart, std::abs(z[i] - other[i]));
    const double swing =
        *std::max_element(z.begin(), z.end()) - *std::min_element(z.begin(), z.end());
    std::printf(
        "%s: one and two threads are %.1e of the swing apart\n", solver.c_str(), apart / swing);
    EXPECT_GT(swing, 1.0);
    // a step's tolerance is 1e-8 of the forces, of which a factor's last digits decide the rest
    EXPECT_LT(apart, 1e-6 * swing);
  }
}

TEST(RunScene, SaysHowItsEquationsAreSolved) {
  const SampleScene sample(with(kStripScene, "element = \"hex8\"", "solver = \"multigrid\""));
  const SceneSummary summary = run_in(sample, sample.folder / "out");
  EXPECT_TRUE(summary.usable()) << summary.run.message;
  EXPECT_TRUE(holds(summary.solver, "multigrid"));
  EXPECT_TRUE(holds(read_file(sample.folder / "out" / "summary.json"), "multigrid cycle"));
}

TEST(RunScene, RowsBeyondTheCheckpointAreCutOff) {
  const SampleScene sample;
  const fs::path whole = sample.folder / "whole";
  static_cast<void>(run_in(sample, whole));
  const fs::path parts = sample.folder / "parts";
  ASSERT_TRUE(run_until(sample, parts, 12.0, false));
  std::ofstream(parts / "energy.csv", std::ios::app) << "0.0013,1,2,3,half a ro";
  std::ofstream(parts / "motion.csv", std::ios::app) << "9,9";
  ASSERT_TRUE(run_in(sample, parts, true).usable());
  EXPECT_EQ(read_file(parts / "energy.csv"), read_file(whole / "energy.csv"));
  EXPECT_EQ(read_file(parts / "motion.csv"), read_file(whole / "motion.csv"));
}

TEST(RunScene, RefusesACheckpointThatCannotBeGoneOnFrom) {
  const SampleScene sample;
  const fs::path out = sample.folder / "out";
  const auto refusal = [&] {
    return refusal_of([&] { static_cast<void>(run_in(sample, out, true)); });
  };
  EXPECT_TRUE(holds(refusal(), "checkpoint.bin: no such file"));
  ASSERT_TRUE(run_until(sample, out, 12.0, false));
  const std::string good = read_file(out / "checkpoint.bin");
  std::string damaged = good;
  damaged[good.size() / 2] = static_cast<char>(damaged[good.size() / 2] ^ 1);
  sample.folder.write("out/checkpoint.bin", damaged);
  EXPECT_TRUE(holds(refusal(), "is damaged"));
  sample.folder.write("out/checkpoint.bin", good.substr(0, good.size() / 2));
  EXPECT_TRUE(holds(refusal(), "is damaged"));
  sample.folder.write("out/checkpoint.bin", "else");
  EXPECT_TRUE(holds(refusal(), "is no checkpoint"));
  sample.folder.write("out/checkpoint.bin", good);
  sample.folder.write("out/energy.csv", "short");
  EXPECT_TRUE(holds(refusal(), "energy.csv: has 5 bytes, must have the"));
  sample.folder.write("scene.toml", with(kStripScene, "5e7", "6e7"));
  EXPECT_TRUE(holds(refusal(), "is of another scene"));
}

TEST(RunScene, AFullDiskEndsInASentence) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  const SampleScene sample;
  for (const char* name : {"energy.csv", "motion.csv"}) {
    const fs::path out = sample.folder / (std::string("full_") + name);
    fs::create_directories(out);
    fs::create_symlink("/dev/full", out / name);
    const std::string message = refusal_of([&] { static_cast<void>(run_in(sample, out)); });
    EXPECT_TRUE(holds(message, std::string(name) + ": cannot be written: No space left"));
  }
}

TEST(RunScene, AStepOfASecondEndsInASentenceOrASoundState) {
  for (const char* modulus : {"5e7", "1e3"}) {
    std::string text = with(kStripScene, "step_s = 1e-4", "step_s = 1.0");
    text = with(text, "duration_s = 4e-3", "duration_s = 3.0");
    text = with(text, "5e7", modulus);
    text = text.substr(0, text.find("[[load]]"));
    const SampleScene sample(text);
    const fs::path out = sample.folder / "out";
    const SceneSummary summary = run_in(sample, out);
    EXPECT_FALSE(summary.run.message.empty());
    const std::string energy = read_file(out / "energy.csv");
    EXPECT_EQ(energy.find("nan"), std::string::npos);
    EXPECT_EQ(energy.find("inf"), std::string::npos);
  }
}

TEST(RunScene, ALoadThatFindsNoEquilibriumIsANumericalFailure) {
  const SampleScene sample(
      with(kStripScene, "displacement_mm = [0.0, 0.0, -4.0]", "force_n = [-1e9, 0.0, 0.0]"));
  try {
    static_cast<void>(run_in(sample, sample.folder / "out"));
    FAIL() << "was accepted";
  } catch (const NumericalFailure& failure) {
    EXPECT_TRUE(holds(failure.what(), "load.1: the body \"strip\" cannot be loaded"));
  }
}

TEST(RunScene, ShakenBaseDoesTheWork) {
  std::string text = kStripScene;
  text = text.substr(0, text.find("[[load]]")) +
         "[[base_motion]]\nbody = \"strip\"\ntrace = \"shake.csv\"\nz_column = \"z\"\n";
  const SampleScene sample(with(text, "damping_stiffness_b_s = 1e-4", "model = \"linear\""));
  std::string trace = "time_s,z\n";
  for (int i = 0; i <= 40; ++i)
    trace += std::to_string(1e-4 * i) + "," + std::to_string(std::sin(0.1 * i)) + "\n";
  sample.folder.write("shake.csv", trace);
  const fs::path out = sample.folder / "out";
  const SceneSummary summary = run_in(sample, out);
  ASSERT_TRUE(summary.usable()) << summary.run.message;
  const Trace energy = read_trace_csv(out / "energy.csv");
  EXPECT_GT(column(energy, "external_work_j").back(), 0.0);
  // Linear: what goes in is found again. 40 residuals of 1e-8 of the forces.
  EXPECT_LT(summary.remainder_rel, 1e-6);
}

}  // namespace
}  // namespace twang
