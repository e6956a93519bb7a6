// How the controller's state and events look on the wire: the JSON shapes of server/api/README.md ("Live"),
// which the server passes on almost unchanged. Unknown is null.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "link/spool.hpp"
#include "operation/controller.hpp"

namespace headstock::link {

/// Everything of "Live" that the agent knows; the server adds machine, name, profile, connected, received,
/// age_ms, program.id/revision/released, trail and drip.
nlohmann::json live_to_json(const operation::Live& live, const std::string& program_sha256);

/// `{"kind":…}` bodies:
/// part {count,total,program,sha256,cycle_s} · alarm {id,code,text:{en,zh},line,column,program,block} ·
/// alarm_cleared {id} · run_started {run,program,sha256} · run_ended {run,outcome,run_s,cutting_s} · state
/// {state,mode} · offset {what,before,after,origin}
NewEvent to_new_event(const operation::TimedEvent& event);

const char* state_name(operation::State state);
const char* mode_name(operation::Mode mode);
/// "cycle_start" … ↔ Action. @return false when there is no such action.
bool action_from_name(const std::string& name, operation::Action& action);
const char* action_name(operation::Action action);

}  // namespace headstock::link
