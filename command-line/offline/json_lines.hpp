// Canonical operations as JSON Lines: the contract of `headstock interpret`. Numbers are written in the
// fewest digits that read back as the same value; nothing is allocated for an ordinary move.
#pragma once

#include <string>
#include <string_view>

#include "interpreter/canonical.hpp"
#include "machine/machine.hpp"

namespace headstock::offline {

class JsonLines {
 public:
  explicit JsonLines(const machine::Machine& machine, std::string_view profile)
      : machine_(machine), profile_(profile) {}

  /// Appends the record of an operation, with its line end.
  void append(const interp::Operation& operation, std::string& out) const;

 private:
  const machine::Machine& machine_;
  std::string_view profile_;
};

}  // namespace headstock::offline
