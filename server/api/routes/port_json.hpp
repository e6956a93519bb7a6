// Shapes that the two files of port routes share.
#pragma once

#include <nlohmann/json.hpp>

#include "db/port_store.hpp"

namespace headstock::api {

nlohmann::json port_transfer_json(const db::PortTransferRow& row);

}  // namespace headstock::api
