// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/error.hpp"

#include <gtest/gtest.h>

#include <string>

namespace twang::test {

/// The message of the InputError that `action` throws; a failure and "" if it throws none.
template <typename Action>
[[nodiscard]] std::string refusal_of(Action&& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "was accepted, must be refused with an InputError";
  return {};
}

/// Whether `text` holds `part`, with both in the message if not.
[[nodiscard]] inline ::testing::AssertionResult holds(const std::string& text,
                                                      const std::string& part) {
  if (text.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "\"" << text << "\" does not hold \"" << part << "\"";
}

}  // namespace twang::test
