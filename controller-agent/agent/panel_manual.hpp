// Moving by hand from the machine's own panel: jog, steps, reference return, MDI, axis lock. There is no way
// from the network to these. A jog is a dead man's button: it has to be asked for again within kJogAlive, or
// the axis stops (the panel's program died, the cable was pulled, the person let go).
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "operation/controller.hpp"

namespace headstock::agent {

inline constexpr std::chrono::milliseconds kJogAlive{250};

/// Network thread.
class PanelManual {
 public:
  PanelManual(boost::asio::io_context& io, operation::Controller& controller);
  ~PanelManual();

  /// {"do":"jog","axis":"X","direction":1,"rapid":false}   again and again; direction 0: the button is let go
  /// {"do":"step","axis":"X","distance":0.1}               {"do":"reference","axis":"X"}
  /// {"do":"mdi","block":"G00 X10."}                        {"do":"axis_lock","axes":"Z"}   "" for none
  /// {"do":"retrace","distance":-10}                        along the traced path, < 0 back
  /// @return nothing when the verb is none of these
  std::optional<operation::CommandResult> carry_out(const std::string& verb, const nlohmann::json& request);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace headstock::agent
