// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stdexcept>
#include <string>

namespace twang {

/// Wrong input: a file, a line, a key or an argument that a person can mend.
///
/// The message is one sentence that names the place (file, line or key), the value found and what
/// was expected. The command line turns it into exit code 2.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message) : std::runtime_error(message) {}
};

/// A computation that ended without a usable answer although its input was well formed (a film in
/// which no mode is found, a stiffness that cannot be factorized). Library functions report this in
/// their results; only functions whose whole purpose is to chain others throw it. The command line
/// turns it into exit code 1.
class NumericalFailure : public std::runtime_error {
 public:
  explicit NumericalFailure(const std::string& message) : std::runtime_error(message) {}
};

}  // namespace twang
