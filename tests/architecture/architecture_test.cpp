// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/architecture/architecture_rules.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace twang::test {
namespace {

TEST(Architecture, OfThisTreeKeepsItsRules) {
  const ArchitectureReport report = check_architecture(TWANG_SOURCE_DIR);
  for (const std::string& violation : report.violations) ADD_FAILURE() << violation;
  // That the tree was read at all: its first two rooms hold more than this.
  EXPECT_GT(report.num_files, 20);
  EXPECT_NE(std::find(report.arrows.begin(), report.arrows.end(), "rigs -> core"),
            report.arrows.end());
}

struct Plant {
  const char* name;
  const char* file;
  const char* content;
  const char* said;  ///< the one violation; empty: none
};

class PlantedInclude : public ::testing::TestWithParam<Plant> {};

TEST_P(PlantedInclude, IsJudgedByTheRules) {
  const TemporaryFolder folder;
  // A sound tree around it.
  folder.write("core/a.hpp", "#pragma once\n#include <Eigen/Core>\n\n#include <string>\n");
  folder.write("capture/b.cpp", "#include \"core/a.hpp\"\n#include <opencv2/core.hpp>\n");
  folder.write("docs/notes.md", "#include \"nowhere.hpp\"\n");
  folder.write("tests/t.cpp", "#include <opencv2/core.hpp>\n#include \"core/a.hpp\"\n");
  folder.write(GetParam().file, GetParam().content);
  const ArchitectureReport report = check_architecture(folder.path());
  const std::string said = GetParam().said;
  ASSERT_EQ(report.violations.size(), said.empty() ? 0U : 1U);
  if (!said.empty()) {
    EXPECT_EQ(report.violations[0], GetParam().file + (":" + said));
  }
}

TEST(Architecture, KnowsEveryRoom) {
  const TemporaryFolder folder;
  folder.write("attic/x.cpp", "int a;\n");
  const ArchitectureReport report = check_architecture(folder.path());
  ASSERT_EQ(report.violations.size(), 1U);
  EXPECT_EQ(report.violations[0], "attic:0: is a room that the rules do not know");
}

INSTANTIATE_TEST_SUITE_P(
    WrongArrow,
    PlantedInclude,
    ::testing::Values(Plant{"CoreOnRigs",
                            "core/x.cpp",
                            "\n#include \"rigs/rig.hpp\"\n",
                            "2: core must not include \"rigs/rig.hpp\" of rigs"},
                      Plant{"FemOnCapture",
                            "fem/x.hpp",
                            "  #  include \"capture/image.hpp\"  // why\n",
                            "1: fem must not include \"capture/image.hpp\" of capture"},
                      Plant{"CoarsenOnSimulate",
                            "coarsen/x.cpp",
                            "#include \"simulate/integrators.hpp\"",
                            "1: coarsen must not include \"simulate/integrators.hpp\" of simulate"},
                      Plant{"SimulateOnCoarsen",
                            "simulate/x.cpp",
                            "#include \"coarsen/mesh_ladder.hpp\"\n",
                            "1: simulate must not include \"coarsen/mesh_ladder.hpp\" of coarsen"},
                      Plant{"InversionOnRigs",
                            "harmonic_inversion/x.cpp",
                            "#include \"rigs/rig.hpp\"\n",
                            "1: harmonic_inversion must not include \"rigs/rig.hpp\" of rigs"},
                      Plant{"ReportOnCalibrate",
                            "report/x.cpp",
                            "#include \"calibrate/calibrate.hpp\"\n",
                            "1: report must not include \"calibrate/calibrate.hpp\" of calibrate"},
                      Plant{"CalibrateOnReport",
                            "calibrate/x.cpp",
                            "#include \"report/html_report.hpp\"\n",
                            "1: calibrate must not include \"report/html_report.hpp\" of report"}),
    [](const auto& plant) { return std::string(plant.param.name); });

INSTANTIATE_TEST_SUITE_P(
    WrongPlace,
    PlantedInclude,
    ::testing::Values(
        Plant{"DetailOfAnother",
              "capture/x.cpp",
              "#include \"rigs/detail/toml_table.hpp\"\n",
              "1: \"rigs/detail/toml_table.hpp\" is a detail of rigs"},
        Plant{"NotFromTheRoot",
              "rigs/x.cpp",
              "#include \"rig.hpp\"\n",
              "1: \"rig.hpp\" must begin with a room; what is not the project's own stands in <>"},
        Plant{"TestSupportInARoom",
              "rigs/x.cpp",
              "#include \"tests/support/a.hpp\"\n",
              "1: \"tests/support/a.hpp\" must begin with a room; what is not the project's own "
              "stands in <>"},
        Plant{"OwnInAngles",
              "rigs/x.cpp",
              "#include <core/a.hpp>\n",
              "1: <core/a.hpp> is the project's own, must stand in quotes"},
        Plant{"ByMacro",
              "rigs/x.cpp",
              "#include HEADER\n",
              "1: is an include by macro, must name its file"},
        Plant{"OpenCvInFem",
              "fem/x.cpp",
              "#include <opencv2/imgproc.hpp>\n",
              "1: fem must not see OpenCV (<opencv2/imgproc.hpp>)"},
        Plant{"FfmpegInCalibrate",
              "calibrate/x.cpp",
              "#include <libavutil/frame.h>\n",
              "1: calibrate must not see FFmpeg (<libavutil/frame.h>)"},
        Plant{"FftwInCapture",
              "capture/x.cpp",
              "#include <fftw3.h>\n",
              "1: capture must not see FFTW (<fftw3.h>)"},
        Plant{"CeresInFem",
              "fem/x.cpp",
              "#include <ceres/ceres.h>\n",
              "1: fem must not see Ceres (<ceres/ceres.h>)"},
        Plant{"ArpackInCoarsen",
              "coarsen/x.cpp",
              "#include <arpack/arpack.hpp>\n",
              "1: coarsen must not see ARPACK (<arpack/arpack.hpp>)"},
        Plant{"CholmodInSimulate",
              "simulate/x.cpp",
              "#include <suitesparse/cholmod.h>\n",
              "1: simulate must not see CHOLMOD (<suitesparse/cholmod.h>)"},
        Plant{"LibraryInAPublicHeader",
              "capture/x.hpp",
              "#include <opencv2/core.hpp>\n",
              "1: <opencv2/core.hpp> in a public header, must be the standard library or Eigen"},
        Plant{"FmtInAPublicHeader",
              "core/x.hpp",
              "#include <fmt/format.h>\n",
              "1: <fmt/format.h> in a public header, must be the standard library or Eigen"}),
    [](const auto& plant) { return std::string(plant.param.name); });

INSTANTIATE_TEST_SUITE_P(
    Sound,
    PlantedInclude,
    ::testing::Values(
        Plant{"OwnDetail", "rigs/x.cpp", "#include \"rigs/detail/toml_table.hpp\"\n", ""},
        Plant{
            "LibraryInADetailHeader", "capture/detail/x.hpp", "#include <opencv2/core.hpp>\n", ""},
        Plant{"CeresInCalibrate", "calibrate/x.cpp", "#include <ceres/ceres.h>\n", ""},
        Plant{"FftwInInversion", "harmonic_inversion/x.cpp", "#include <fftw3.h>\n", ""},
        Plant{"CholmodInFem", "fem/x.cpp", "#include <cholmod.h>\n", ""},
        Plant{"CoarsenOnFem", "coarsen/x.hpp", "#include \"fem/hex_mesh.hpp\"\n", ""},
        Plant{
            "AppOnReport", "app/x.hpp", "#include \"report/a.hpp\"\n#include <CLI/CLI.hpp>\n", ""},
        Plant{"CommentedOut", "core/x.cpp", "// #include \"fem/hex_mesh.hpp\"\n", ""}),
    [](const auto& plant) { return std::string(plant.param.name); });

}  // namespace
}  // namespace twang::test
