#include "plc/built_in.hpp"

#include <gtest/gtest.h>

namespace headstock::plc {
namespace {

int periods_until_finished(BuiltIn& plc, const Inputs& inputs) {
  int periods = 0;
  while (!plc.finished() && periods < 10'000) {
    plc.step(inputs);
    ++periods;
  }
  return periods;
}

Inputs at_speed(bool reached) {
  Inputs inputs;
  inputs.spindle_at_speed = reached;
  inputs.period_s = 0.001;
  return inputs;
}

Request m_code(int code) {
  Request request;
  request.code = code;
  return request;
}

TEST(BuiltIn, AnMCodeTakesItsTime) {
  BuiltIn plc({0.05, 1.0});
  EXPECT_TRUE(plc.finished());
  plc.request(m_code(33));
  EXPECT_FALSE(plc.finished());
  EXPECT_EQ(periods_until_finished(plc, at_speed(true)), 50);
}

TEST(BuiltIn, AToolTakesItsOwnTimeAndIsThenInPlace) {
  BuiltIn plc({0.01, 0.2});
  Request tool;
  tool.kind = FunctionKind::tool;
  tool.code = 7;
  plc.request(tool);
  EXPECT_EQ(periods_until_finished(plc, at_speed(true)), 200);
  EXPECT_EQ(plc.outputs().tool, 7);
}

TEST(BuiltIn, TheSpindleIsFinishedAtSpeedOnly) {
  BuiltIn plc({0.01, 0.2});
  Request spindle;
  spindle.kind = FunctionKind::spindle;
  spindle.turning = Turning::counterclockwise;
  spindle.speed = 800;
  plc.request(spindle);
  EXPECT_EQ(plc.outputs().turning, Turning::counterclockwise);
  for (int i = 0; i < 500; ++i) plc.step(at_speed(false));
  EXPECT_FALSE(plc.finished());
  plc.step(at_speed(true));
  EXPECT_TRUE(plc.finished());
}

TEST(BuiltIn, CoolantFollowsM07M08M09AndResetStopsAllButTheTool) {
  BuiltIn plc;
  const auto give = [&](int code) {
    plc.request(m_code(code));
    periods_until_finished(plc, {});
  };
  give(8);
  EXPECT_TRUE(plc.outputs().coolant);
  give(9);
  EXPECT_FALSE(plc.outputs().coolant);
  give(7);
  EXPECT_TRUE(plc.outputs().mist);
  Request tool;
  tool.kind = FunctionKind::tool;
  tool.code = 3;
  plc.request(tool);
  plc.reset();
  EXPECT_TRUE(plc.finished());
  EXPECT_FALSE(plc.outputs().mist);
  EXPECT_EQ(plc.outputs().tool, 3);
}

TEST(BuiltIn, OrientationAndContourAreFinishedWhenTheSpindleIsThere) {
  BuiltIn plc({0.01, 0.2}, {19, 14, 15});
  Inputs inputs = at_speed(true);
  plc.request(m_code(19));
  EXPECT_TRUE(plc.outputs().orient);
  EXPECT_EQ(plc.outputs().turning, Turning::stop);
  for (int i = 0; i < 100; ++i) plc.step(inputs);
  EXPECT_FALSE(plc.finished());
  inputs.spindle_oriented = true;
  plc.step(inputs);
  EXPECT_TRUE(plc.finished());
  plc.request(m_code(14));
  EXPECT_TRUE(plc.outputs().contour);
  EXPECT_FALSE(plc.outputs().orient);
  inputs.contour_ready = true;
  for (int i = 0; i < 100; ++i) plc.step(inputs);
  EXPECT_TRUE(plc.finished());
  plc.request(m_code(15));
  EXPECT_FALSE(plc.outputs().contour);
  const std::uint32_t orders = plc.outputs().spindle_orders;
  plc.reset();
  EXPECT_GT(plc.outputs().spindle_orders, orders) << "what held the spindle lets go";
}

}  // namespace
}  // namespace headstock::plc
