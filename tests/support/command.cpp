// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/command.hpp"

#include "core/atomic_file.hpp"
#include "tests/support/temporary_folder.hpp"

#include <sys/wait.h>

#include <cstdlib>

namespace twang::test {
namespace {

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'') {
      result.append("'\\''");
    } else {
      result.push_back(c);
    }
  }
  result.push_back('\'');
  return result;
}

}  // namespace

CommandOutcome run_twang(const std::vector<std::string>& arguments) {
  const TemporaryFolder folder;
  std::string line = quoted(TWANG_EXECUTABLE);
  for (const std::string& argument : arguments) line.append(" ").append(quoted(argument));
  const std::string out = (folder / "out").string();
  const std::string err = (folder / "err").string();
  line.append(" >").append(quoted(out)).append(" 2>").append(quoted(err)).append(" </dev/null");
  const int status = std::system(line.c_str());
  CommandOutcome outcome;
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  outcome.out = read_file(out);
  outcome.err = read_file(err);
  return outcome;
}

}  // namespace twang::test
