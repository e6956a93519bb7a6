// What of Boost.Beast is no template, compiled here once (its documentation: "separate compilation").
#include <boost/beast/src.hpp>
