// What every unit test reads (see headstock_common_headers).
#pragma once

#include "standard.hpp"

#include <random>

#include <gtest/gtest.h>
