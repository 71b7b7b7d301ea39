// The five-bar has moved to its place among the robot kinds; this name stays for a while.
#pragma once

#include "geometry/robots/five_bar.h"
