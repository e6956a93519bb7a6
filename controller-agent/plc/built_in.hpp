// The answer for machines without a ladder of their own: M03/M04/M05 drive the spindle and finish at speed,
// M19 orients it, M07/M08/M09 switch coolant, T takes a tool, every other code just takes its time.
#pragma once

#include "plc/auxiliary.hpp"

namespace headstock::plc {

/// How long functions take, seconds.
struct Times {
  double m_s = 0.016;   ///< TFIN: the shortest FIN a FANUC accepts by default (No. 3011)
  double tool_s = 0.5;  ///< turret or magazine
};

/// M codes of the spindle beside M03…M05; 0: the machine has none.
struct SpindleCodes {
  std::int32_t orient = 0, contour_on = 0, contour_off = 0;
};

class BuiltIn final : public Auxiliary {
 public:
  explicit BuiltIn(const Times& times = {}, const SpindleCodes& codes = {}) : times_(times), codes_(codes) {}
  void request(const Request& request) noexcept override;
  void step(const Inputs& inputs) noexcept override;
  bool finished() const noexcept override { return finished_; }
  const Outputs& outputs() const noexcept override { return outputs_; }
  void reset() noexcept override;

 private:
  void place_spindle(bool orient, bool contour) noexcept;

  Times times_;
  SpindleCodes codes_;
  Outputs outputs_;
  Request request_;
  double remaining_s_ = 0;
  bool finished_ = true;
};

}  // namespace headstock::plc
