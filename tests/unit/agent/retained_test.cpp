// What the agent remembers over a restart: changes that come with power on are told as such.
#include "agent/retained.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "link/spool.hpp"
#include "machine/machine.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace headstock::agent {
namespace {

using nlohmann::json;

struct PowerOn : testing::Test {
  testing_support::TemporaryFolder folder;
  link::Spool spool{folder.path() / "spool.sqlite"};
  machine::Machine machine = *machine::default_machine("fanuc-0i-t");

  void keep(const interp::MachineData& data) {
    const link::RetainedValue value = data_value(data, machine);
    spool.commit({}, {&value, 1});
  }
};

TEST_F(PowerOn, WhatDoesNotOutliveItIsTold) {
  interp::MachineData data = read_data(spool, machine);
  data.common_variables = {{100, 2.5}, {500, 7}};
  data.tools[3].wear[0] = 0.02;
  keep(data);
  store_power_on(spool, read_data(spool, machine), machine);
  const auto events = spool.read_after(0);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, "offset");
  const json told = json::parse(events[0].body);
  EXPECT_EQ(told["what"], "variable/100");
  EXPECT_EQ(told["before"], 2.5);
  EXPECT_TRUE(told["after"].is_null());
  EXPECT_EQ(told["origin"], "power_on");
  const interp::MachineData stored = read_data(spool, machine, Variables::all);
  EXPECT_FALSE(stored.common_variables.contains(100)) << "told and stored together";
  EXPECT_EQ(stored.common_variables.at(500), 7);
  EXPECT_EQ(stored.tools[3].wear[0], 0.02);
  store_power_on(spool, read_data(spool, machine), machine);
  EXPECT_EQ(spool.last_sequence(), 1u) << "told once";
}

TEST_F(PowerOn, TheFirstOneHasNothingToDifferFrom) {
  interp::MachineData data = read_data(spool, machine);
  data.common_variables[500] = 0;
  ++data.version;
  store_power_on(spool, data, machine);
  EXPECT_EQ(spool.last_sequence(), 0u);
  EXPECT_TRUE(read_data(spool, machine).common_variables.contains(500))
      << "on the disk before it is reported";
}

}  // namespace
}  // namespace headstock::agent
