#!/usr/bin/python3
"""Six gauges on Modbus TCP by Debian's python3-pymodbus: an independent peer for the driver's test.

usage: /usr/bin/python3 pymodbus_gauges.py PORT     (on 127.0.0.1; prints "ready" before it serves)

Gauge k = 1..6 shows 1000 k + 345 micrometres, gauge 6 the negative of 45.
Input registers 0..11 int32 micrometres, 100..105 status 0, 8000..8011 float32 mm; high word first.
Registers 200..211 hold the same integers with the low word first.
"""
import asyncio
import struct
import sys

from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.server import StartAsyncTcpServer


def halves(packed):
    return list(struct.unpack(">HH", packed))


def gauges():
    block = ModbusSequentialDataBlock(0, [0] * 9000)
    for k in range(6):
        micrometres = 1000 * (k + 1) + 345 if k < 5 else -45
        words = halves(struct.pack(">i", micrometres))
        block.setValues(2 * k, words)
        block.setValues(200 + 2 * k, words[::-1])
        block.setValues(8000 + 2 * k, halves(struct.pack(">f", micrometres / 1000.0)))
    return block


async def main():
    empty = ModbusSequentialDataBlock(0, [0] * 16)
    unit = ModbusSlaveContext(ir=gauges(), hr=gauges(), di=empty, co=empty, zero_mode=True)
    print("ready", flush=True)
    await StartAsyncTcpServer(
        context=ModbusServerContext(slaves=unit, single=True),
        address=("127.0.0.1", int(sys.argv[1])))


asyncio.run(main())
