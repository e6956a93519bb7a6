// What nearly every source of the server reads: values that travel as JSON (see headstock_common_headers).
#pragma once

#include "standard.hpp"

#include <nlohmann/json.hpp>
