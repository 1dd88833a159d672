//! Messages on a pipe: their length in bytes (u64, little-endian), then MessagePack, in which numbers keep
//! every bit. A reader takes memory as bytes arrive, not as the length says.

use std::io::{self, Read, Write};

use serde::Serialize;
use serde::de::DeserializeOwned;
use tokio::io::{AsyncRead, AsyncReadExt};

/// A message with its length.
pub fn encode<T: Serialize>(message: &T) -> io::Result<Vec<u8>> {
    let mut frame = vec![0; size_of::<u64>()];
    // With names: some fields are left out where they are empty.
    let mut serializer = rmp_serde::Serializer::new(&mut frame).with_struct_map();
    message
        .serialize(&mut serializer)
        .map_err(io::Error::other)?;
    let length = (frame.len() - size_of::<u64>()) as u64;
    frame[..size_of::<u64>()].copy_from_slice(&length.to_le_bytes());
    Ok(frame)
}

pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> io::Result<T> {
    rmp_serde::from_slice(bytes).map_err(io::Error::other)
}

pub fn write<T: Serialize>(pipe: &mut impl Write, message: &T) -> io::Result<()> {
    pipe.write_all(&encode(message)?)?;
    pipe.flush()
}

pub fn read<T: DeserializeOwned>(pipe: &mut impl Read) -> io::Result<T> {
    let mut length = [0; size_of::<u64>()];
    pipe.read_exact(&mut length)?;
    let length = u64::from_le_bytes(length);
    let mut bytes = Vec::new();
    pipe.take(length).read_to_end(&mut bytes)?;
    decode(whole(&bytes, length)?)
}

/// The bytes of one message.
pub async fn receive(pipe: &mut (impl AsyncRead + Unpin)) -> io::Result<Vec<u8>> {
    let length = pipe.read_u64_le().await?;
    let mut bytes = Vec::new();
    pipe.take(length).read_to_end(&mut bytes).await?;
    whole(&bytes, length)?;
    Ok(bytes)
}

fn whole(bytes: &[u8], length: u64) -> io::Result<&[u8]> {
    match bytes.len() as u64 == length {
        true => Ok(bytes),
        false => Err(io::ErrorKind::UnexpectedEof.into()),
    }
}
