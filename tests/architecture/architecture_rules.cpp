// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/architecture/architecture_rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string_view>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

/// Which rooms a room may include besides itself.
const std::map<std::string, std::set<std::string>>& arrows_allowed() {
  static const std::map<std::string, std::set<std::string>> kArrows = {
      {"core", {}},
      {"rigs", {"core"}},
      {"capture", {"rigs", "core"}},
      {"harmonic_inversion", {"core"}},
      {"fem", {"rigs", "core"}},
      {"coarsen", {"fem", "rigs", "core"}},
      {"contact", {"fem", "rigs", "core"}},
      {"simulate", {"contact", "fem", "rigs", "core"}},
      {"calibrate",
       {"simulate", "contact", "coarsen", "fem", "harmonic_inversion", "capture", "rigs", "core"}},
      {"report", {"core"}},
      {"app",
       {"report",
        "calibrate",
        "simulate",
        "contact",
        "coarsen",
        "fem",
        "harmonic_inversion",
        "capture",
        "rigs",
        "core"}},
  };
  return kArrows;
}

struct Library {
  const char* name;
  std::vector<std::string> beginnings;  ///< of the paths of its headers
  std::set<std::string> rooms;          ///< that may see it

  [[nodiscard]] bool owns(const std::string& path) const {
    return std::any_of(beginnings.begin(), beginnings.end(), [&](const std::string& beginning) {
      return path.starts_with(beginning);
    });
  }
};

const std::vector<Library>& confined_libraries() {
  static const std::vector<Library> kLibraries = {
      {"OpenCV", {"opencv"}, {"capture"}},
      {"FFmpeg", {"libav", "libsw", "libpostproc"}, {"capture"}},
      {"AprilTag", {"apriltag"}, {"capture"}},
      {"FFTW", {"fftw3"}, {"harmonic_inversion"}},
      {"Ceres", {"ceres/"}, {"harmonic_inversion", "calibrate"}},
      {"ARPACK", {"arpack", "parpack"}, {"fem"}},
      {"CHOLMOD", {"cholmod", "suitesparse/cholmod", "Eigen/CholmodSupport"}, {"fem"}},
  };
  return kLibraries;
}

/// Whether `path` names a header of the C++ standard library ("vector") or of Eigen.
bool is_standard_or_eigen(std::string_view path) {
  if (path.starts_with("Eigen/")) return true;
  return std::all_of(path.begin(), path.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

std::string_view without_leading_blanks(std::string_view text) {
  return text.substr(std::min(text.find_first_not_of(" \t"), text.size()));
}

/// What follows `#include` in a line, nothing if the line is no such directive.
std::optional<std::string_view> after_include(std::string_view line) {
  line = without_leading_blanks(line);
  if (!line.starts_with('#')) return std::nullopt;
  line = without_leading_blanks(line.substr(1));
  constexpr std::string_view kInclude = "include";
  if (!line.starts_with(kInclude)) return std::nullopt;
  return without_leading_blanks(line.substr(kInclude.size()));
}

struct Include {
  std::string file;  ///< from the root
  int line = 0;
  std::string room;  ///< that includes
  bool quoted = false;
  std::string path;
};

/// Gathers what is wrong and which arrows there are.
class Checker {
 public:
  void check(const Include& include) {
    if (include.quoted) {
      check_own(include);
    } else {
      check_foreign(include);
    }
  }
  void check_line(const std::string& file,
                  const std::string& room,
                  int line,
                  const std::string& s) {
    const auto rest = after_include(s);
    if (!rest) return;
    const bool quoted = rest->starts_with('"');
    const std::size_t end = rest->find(quoted ? '"' : '>', 1);
    if ((!quoted && !rest->starts_with('<')) || end == std::string_view::npos) {
      complain(file, line, "is an include by macro, must name its file");
      return;
    }
    check({file, line, room, quoted, std::string(rest->substr(1, end - 1))});
  }
  void complain(const std::string& file, int line, const std::string& what) {
    m_report.violations.push_back(fmt::format("{}:{}: {}", file, line, what));
  }
  void count_file() { ++m_report.num_files; }
  ArchitectureReport report() && {
    m_report.arrows.assign(m_arrows.begin(), m_arrows.end());
    return std::move(m_report);
  }

 private:
  void check_own(const Include& include) {
    const std::string target = include.path.substr(0, include.path.find('/'));
    if (target == include.path || !arrows_allowed().contains(target)) {
      complain(include.file,
               include.line,
               fmt::format("\"{}\" must begin with a room; what is not the project's own stands in "
                           "<>",
                           include.path));
      return;
    }
    if (include.path.find("..") != std::string::npos) {
      complain(include.file,
               include.line,
               fmt::format("\"{}\" must be a path from the root without ..", include.path));
    }
    if (target == include.room) return;
    m_arrows.insert(include.room + " -> " + target);
    if (!arrows_allowed().at(include.room).contains(target)) {
      complain(include.file,
               include.line,
               fmt::format("{} must not include \"{}\" of {}", include.room, include.path, target));
    }
    if (include.path.find("/detail/") != std::string::npos) {
      complain(include.file,
               include.line,
               fmt::format("\"{}\" is a detail of {}", include.path, target));
    }
  }

  void check_foreign(const Include& include) {
    for (const Library& library : confined_libraries()) {
      if (library.owns(include.path) && !library.rooms.contains(include.room)) {
        complain(
            include.file,
            include.line,
            fmt::format("{} must not see {} (<{}>)", include.room, library.name, include.path));
      }
    }
    if (arrows_allowed().contains(include.path.substr(0, include.path.find('/')))) {
      complain(include.file,
               include.line,
               fmt::format("<{}> is the project's own, must stand in quotes", include.path));
    }
    const bool is_public_header = include.file.ends_with(".hpp") && include.room != "app" &&
                                  include.file.find("/detail/") == std::string::npos;
    if (is_public_header && !is_standard_or_eigen(include.path)) {
      complain(include.file,
               include.line,
               fmt::format("<{}> in a public header, must be the standard library or Eigen",
                           include.path));
    }
  }

  ArchitectureReport m_report;
  std::set<std::string> m_arrows;
};

bool is_source(const fs::path& path) {
  static const std::set<std::string> kExtensions = {".cpp", ".hpp", ".cc", ".h", ".inl", ".ipp"};
  return kExtensions.contains(path.extension().string());
}

/// Folders of the root that hold no room.
bool is_room(const fs::directory_entry& folder) {
  static const std::set<std::string> kOthers = {"tests", "bench", "build", "scripts", "cmake"};
  const std::string name = folder.path().filename().string();
  if (!folder.is_directory() || name.starts_with('.') || kOthers.contains(name)) return false;
  const auto entries = fs::recursive_directory_iterator(folder);
  return std::any_of(
      begin(entries), end(entries), [](const auto& entry) { return is_source(entry.path()); });
}

}  // namespace

ArchitectureReport check_architecture(const fs::path& root) {
  Checker checker;
  for (const auto& folder : fs::directory_iterator(root)) {
    if (!is_room(folder)) continue;
    const std::string room = folder.path().filename().string();
    if (!arrows_allowed().contains(room)) {
      checker.complain(room, 0, "is a room that the rules do not know");
      continue;
    }
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (!entry.is_regular_file() || !is_source(entry.path())) continue;
      checker.count_file();
      std::ifstream stream(entry.path());
      const std::string file = entry.path().lexically_relative(root).generic_string();
      int number = 0;
      for (std::string line; std::getline(stream, line);) {
        checker.check_line(file, room, ++number, line);
      }
    }
  }
  return std::move(checker).report();
}

}  // namespace twang::test
