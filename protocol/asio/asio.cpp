// What of Boost.Asio is no template, compiled here once (its documentation: "separate compilation").
#include <boost/asio/impl/src.hpp>
#include <boost/asio/ssl/impl/src.hpp>
