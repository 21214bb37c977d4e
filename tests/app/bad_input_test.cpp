// SPDX-License-Identifier: GPL-3.0-or-later
// What a user can do wrong: one sentence on stderr, exit code 2, nothing written.
#include "capture/video_writer.hpp"
#include "core/atomic_file.hpp"
#include "tests/support/command.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

const std::string kStrip = std::string(TWANG_SOURCE_DIR) + "/rigs/strip.toml";
const std::string kStripFilm = std::string(TWANG_SOURCE_DIR) + "/videos_sample/strip.mp4";

/// A grey film without a marker in it.
void write_empty_film(const fs::path& path) {
  constexpr int kWidth = 320;
  constexpr int kHeight = 180;
  VideoWriter writer(path, kWidth, kHeight, {240.0, 18});
  Image image{kWidth,
              kHeight,
              1,
              std::vector<std::uint8_t>(static_cast<std::size_t>(kWidth * kHeight), 128)};
  for (int frame = 0; frame < 20; ++frame) {
    image.pixels[static_cast<std::size_t>(frame)] = 130;
    writer.write(image);
  }
  writer.finish();
}

std::string with_line_replaced(const std::string& text,
                               const std::string& old_line,
                               const std::string& new_line) {
  const std::size_t at = text.find(old_line);
  if (at == std::string::npos) throw std::runtime_error("the rig has no line '" + old_line + "'");
  std::string changed = text;
  return changed.replace(at, old_line.size(), new_line);
}

/// Runs `calibrate` and `track` on a rig and a film; both must refuse with one sentence that holds
/// `must_name`.
void expect_refused(const std::vector<std::string>& arguments, const std::string& must_name) {
  const CommandOutcome outcome = run_twang(arguments);
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NE(outcome.err.find(must_name), std::string::npos)
      << outcome.err << "\nmust name: " << must_name;
}

class BadInput : public testing::Test {
 protected:
  void expect_film_refused(const fs::path& film, const std::string& must_name) {
    const std::size_t before = folder.num_entries();
    expect_refused({"calibrate", kStrip, film.string(), "--out", (folder / "new" / "out").string()},
                   must_name);
    expect_refused({"track",
                    kStrip,
                    film.string(),
                    "-o",
                    (folder / "trace.csv").string(),
                    "--overlay",
                    (folder / "overlay.mp4").string()},
                   must_name);
    EXPECT_EQ(folder.num_entries(), before) << "something was left behind";
  }
  void expect_rig_refused(const std::string& rig_text, const std::string& must_name) {
    const fs::path rig = folder / "rig.toml";
    write_file_atomically(rig, rig_text);
    const std::size_t before = folder.num_entries();
    expect_refused({"calibrate", rig.string(), kStripFilm, "--out", (folder / "out").string()},
                   must_name);
    EXPECT_EQ(folder.num_entries(), before) << "something was left behind";
  }
  void expect_trace_refused(const std::string& csv, const std::string& must_name) {
    const fs::path trace = folder / "trace.csv";
    write_file_atomically(trace, csv);
    const std::size_t before = folder.num_entries();
    expect_refused(
        {"calibrate", kStrip, "--trace", trace.string(), "--out", (folder / "out").string()},
        must_name);
    expect_refused({"invert", trace.string(), "--json", (folder / "modes.json").string()},
                   must_name);
    EXPECT_EQ(folder.num_entries(), before) << "something was left behind";
  }
  TemporaryFolder folder;
};

TEST_F(BadInput, NoSuchFilm) { expect_film_refused(folder / "missing.mp4", "missing.mp4"); }

TEST_F(BadInput, TextFileAsFilm) {
  write_file_atomically(folder / "text.mp4", "this is no film\n");
  expect_film_refused(folder / "text.mp4", "text.mp4");
}

TEST_F(BadInput, EmptyFilm) {
  write_file_atomically(folder / "empty.mp4", "");
  expect_film_refused(folder / "empty.mp4", "empty.mp4");
}

TEST_F(BadInput, FilmWithoutMarkers) {
  write_empty_film(folder / "grey.mp4");
  expect_film_refused(folder / "grey.mp4", "grey.mp4");
}

TEST_F(BadInput, FilmTruncatedAtEveryTenth) {
  const std::string whole = read_file(kStripFilm);
  for (std::size_t tenth = 1; tenth < 10; ++tenth) {
    write_file_atomically(folder / "cut.mp4", whole.substr(0, whole.size() * tenth / 10));
    expect_film_refused(folder / "cut.mp4", "cut.mp4");
  }
}

TEST_F(BadInput, RigWithUnknownKeyNamesTheNearest) {
  const std::string rig = with_line_replaced(read_file(kStrip), "density_kg_m3", "densty_kg_m3");
  expect_rig_refused(rig, "density_kg_m3");
  expect_rig_refused(rig, "rig.toml:");
}

TEST_F(BadInput, RigWithNegativeSize) {
  expect_rig_refused(with_line_replaced(read_file(kStrip), "size_mm = ", "size_mm = -"), "size_mm");
}

TEST_F(BadInput, RigWithMarkerOffThePart) {
  expect_rig_refused(
      with_line_replaced(read_file(kStrip), "position_mm = [76.0, ", "position_mm = [176.0, "),
      "marker.1.position_mm");
}

TEST_F(BadInput, EmptyTrace) { expect_trace_refused("", "trace.csv"); }

TEST_F(BadInput, TraceWithHeaderOnly) {
  expect_trace_refused("time_s,observable_mm\n", "trace.csv");
}

TEST_F(BadInput, TraceOfNan) {
  std::string csv = "time_s,observable_mm\n";
  for (int i = 0; i < 100; ++i) csv += std::to_string(0.01 * i) + ",nan\n";
  expect_trace_refused(csv, "trace.csv");
}

TEST_F(BadInput, TraceWithWordsNamesTheLine) {
  expect_trace_refused("time_s,observable_mm\n0,1\n0.1,two\n", "trace.csv:3");
}

TEST_F(BadInput, TraceOfAForeignSpreadsheet) {
  expect_trace_refused("time_s;observable_mm\n0;1,5\n", "separated by semicolons");
  expect_trace_refused("time_s,observable_mm\n0,\"1,5\"\n", "decimal point");
}

TEST_F(BadInput, TrackOptionsThatContradictEachOther) {
  const std::string csv = (folder / "t.csv").string();
  const std::string out = (folder / "out").string();
  expect_refused({"track", kStrip, kStripFilm}, "neither -o nor --out");
  expect_refused({"track", kStrip, kStripFilm, "-o", csv, "--out", out}, "both -o and --out");
  expect_refused({"track", kStrip, kStripFilm, kStripFilm, "-o", csv}, "one trace for 2 films");
  expect_refused({"track", kStrip, kStripFilm, kStripFilm, "--out", out}, "would both write");
  expect_refused({"track", kStrip, kStripFilm, "--out", out, "--overlay", csv},
                 "--overlay goes with");
  expect_refused({"track", kStrip, kStripFilm, "--out", out, "--sheet", csv}, "--sheet goes with");
  expect_refused({"track", kStrip, kStripFilm, "-o", csv, "--overlays"}, "--overlays goes with");
  expect_refused({"track", kStrip, kStripFilm, "-o", kStripFilm}, "would be written over");
  EXPECT_EQ(folder.num_entries(), 0U);
}

TEST_F(BadInput, FilmsThatAllFail) {
  write_file_atomically(folder / "a.mp4", "no film");
  write_file_atomically(folder / "b.mp4", "");
  const std::size_t before = folder.num_entries();
  const CommandOutcome outcome = run_twang({"track",
                                            kStrip,
                                            (folder / "a.mp4").string(),
                                            (folder / "b.mp4").string(),
                                            "--out",
                                            (folder / "new" / "out").string()});
  EXPECT_EQ(outcome.exit_code, 2);
  // one sentence a film, and how many they are
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 3) << outcome.err;
  EXPECT_EQ(folder.num_entries(), before) << "something was left behind";
}

TEST_F(BadInput, ChecksOfNothing) {
  expect_refused({"check", (folder / "none.toml").string()}, "none.toml");
  expect_refused({"check", kStrip, (folder / "none.mp4").string()}, "none.mp4");
  expect_refused({"check", kStrip, "--exposure", "0"}, "--exposure");
  expect_refused({"check", kStrip, "--capture-fps", "-1"}, "capture");
  expect_refused({"check", kStrip, "--marker", "tip=1,2"}, "--marker");
  write_file_atomically(folder / "text.mp4", "no film");
  expect_refused({"check", kStrip, (folder / "text.mp4").string()}, "text.mp4");
  const fs::path bare = folder / "bare.toml";
  write_file_atomically(bare, "format = \"twang-rig/1\"\nname = \"bare\"\n");
  expect_refused({"check", bare.string()}, "marker");
}

TEST_F(BadInput, CheckOfAFilmWithoutMarkersSaysSo) {
  write_empty_film(folder / "grey.mp4");
  const CommandOutcome outcome =
      run_twang({"check", kStrip, (folder / "grey.mp4").string(), "--json", "-"});
  EXPECT_EQ(outcome.exit_code, 1) << "the film is one, but it cannot be tracked";
  EXPECT_NE(outcome.out.find("\"can_be_filmed\": false"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.err.find("1 problem"), std::string::npos) << outcome.err;
}

TEST_F(BadInput, MarkerSheetsThatCannotBe) {
  const std::string sheet = (folder / "sheet.svg").string();
  expect_refused({"markers", (folder / "none.toml").string(), "-o", sheet}, "none.toml");
  expect_refused({"markers", kStrip, "-o", (folder / "sheet.pdf").string()}, "sheet.pdf");
  expect_refused({"markers", kStrip, "-o", (folder / "no" / "sheet.svg").string()}, "no");
  const fs::path bare = folder / "bare.toml";
  write_file_atomically(bare, "format = \"twang-rig/1\"\nname = \"bare\"\n");
  expect_refused({"markers", bare.string(), "-o", sheet}, "no marker to print");
  EXPECT_FALSE(fs::exists(sheet));
}

TEST_F(BadInput, UnknownCommandsAndOptions) {
  expect_refused({"calibrat"}, "calibrat");
  expect_refused({"invert", "--colum", "x", "trace.csv"}, "--colum");
  expect_refused({"modes", kStrip, "--dx", "0"}, "--dx");
  expect_refused({"modes", kStrip, "--dx", "-1"}, "--dx");
  expect_refused({"modes", kStrip, "--dx", "2", "--element", "hex9"}, "hex9");
  expect_refused(
      {"track", kStrip, kStripFilm, "-o", (folder / "t.csv").string(), "--marker", "tip=5"},
      "tip=5");
  expect_refused(
      {"track", kStrip, kStripFilm, "-o", (folder / "t.csv").string(), "--capture-fps", "-3"},
      "capture");
  expect_refused({"table", (folder / "nothing").string()}, "nothing");
  EXPECT_EQ(folder.num_entries(), 0U);
}

TEST_F(BadInput, AnOverlayOfAValidationNeedsItsFilmAndDoesNotReplaceIt) {
  const std::vector<std::string> validate = {
      "validate", kStrip, "--material", "m.json", "--trace", "t.csv", "--overlay"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), validate.begin(), validate.end());
    return more;
  };
  const std::string film = (folder / "film.mkv").string();
  write_empty_film(film);
  expect_refused(with({"o.mp4"}), "--video");
  expect_refused(with({film, "--video", film}), "written over");
}

}  // namespace
}  // namespace twang::test
