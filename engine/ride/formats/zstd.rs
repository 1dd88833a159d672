//! Zstandard: the text of all frames of a file, one after the other.

use std::io::{self, Read};

use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};

/// What `zstd -22 --ultra` needs on files of that size; more is a claim on our memory.
const WINDOW: u64 = 32 << 20;

pub struct Zstd<'a> {
    packed: &'a [u8],
    decoder: FrameDecoder,
    in_frame: bool,
}

impl<'a> Zstd<'a> {
    pub fn new(packed: &'a [u8]) -> Self {
        let mut decoder = FrameDecoder::new();
        decoder.set_max_window_size(WINDOW);
        Self {
            packed,
            decoder,
            in_frame: false,
        }
    }

    /// Begins the next frame, or steps over one that holds no text.
    fn begin(&mut self) -> io::Result<()> {
        match self.decoder.reset(&mut self.packed) {
            Ok(()) => self.in_frame = true,
            Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                length,
                ..
            })) => {
                let rest = self.packed.get(length as usize..);
                self.packed = rest.ok_or(io::ErrorKind::UnexpectedEof)?;
            }
            Err(error) => return Err(io::Error::other(error)),
        }
        Ok(())
    }

    /// Ends a frame whose bytes are those of its sum, where it has one.
    fn end(&mut self) -> io::Result<()> {
        let reported = self.decoder.get_checksum_from_data();
        if reported.is_some() && reported != self.decoder.get_calculated_checksum() {
            return Err(io::Error::other("its checksum does not match its bytes"));
        }
        self.in_frame = false;
        Ok(())
    }
}

impl Read for Zstd<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        while !out.is_empty() {
            if !self.in_frame {
                if self.packed.is_empty() {
                    break;
                }
                self.begin()?;
                continue;
            }
            let read = self.decoder.read(out)?;
            if read > 0 {
                return Ok(read);
            }
            if self.decoder.is_finished() {
                self.end()?;
                continue;
            }
            let one = BlockDecodingStrategy::UptoBlocks(1);
            let decoded = self.decoder.decode_blocks(&mut self.packed, one);
            decoded.map_err(io::Error::other)?;
        }
        Ok(0)
    }
}

#[cfg(test)]
pub mod tests {
    #![allow(clippy::unwrap_used)]
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    use super::*;

    pub fn packed(bytes: &[u8]) -> Vec<u8> {
        compress_to_vec(bytes, CompressionLevel::Fastest)
    }

    /// What `zstd -19 --check` of version 1.5.4 made of [`lines`].
    const OF_ZSTD: &[u8] = include_bytes!("level_19.zst");

    fn lines() -> String {
        let line = |i: u32| format!("{i};{}.{}\n", i * i % 97, i * 7919 % 1000);
        (1..=400).map(line).collect()
    }

    fn unpacked(bytes: &[u8]) -> io::Result<Vec<u8>> {
        let mut text = Vec::new();
        Zstd::new(bytes).read_to_end(&mut text)?;
        Ok(text)
    }

    #[test]
    fn all_frames_are_read_and_those_without_text_are_not() {
        assert_eq!(unpacked(OF_ZSTD).unwrap(), lines().as_bytes());
        let note = b"\x5a\x2a\x4d\x18\x03\x00\x00\x00abc";
        let many = [note, OF_ZSTD, note, &packed(b"401\n"), &packed(b"")].concat();
        assert_eq!(
            unpacked(&many).unwrap(),
            [lines().as_bytes(), b"401\n"].concat()
        );
        assert!(unpacked(b"").unwrap().is_empty());
    }

    #[test]
    fn what_is_cut_altered_or_no_frame_is_refused() {
        for length in 1..OF_ZSTD.len() {
            assert!(unpacked(&OF_ZSTD[..length]).is_err(), "{length} bytes");
        }
        let mut altered = OF_ZSTD.to_vec();
        *altered.last_mut().unwrap() ^= 1;
        let fault = unpacked(&altered).unwrap_err().to_string();
        assert!(fault.contains("checksum"), "{fault}");
        assert!(unpacked(&[OF_ZSTD, b"0,1\n"].concat()).is_err());
        assert!(unpacked(b"\x5a\x2a\x4d\x18\xff\xff\xff\xff").is_err());
    }

    #[test]
    fn a_window_larger_than_32_mb_is_refused() {
        // No checksum, no size; the window; an empty last block.
        let with = |window: u8| [0x28, 0xb5, 0x2f, 0xfd, 0x00, window, 0x01, 0x00, 0x00];
        assert_eq!(unpacked(&with(15 << 3)).unwrap(), b"");
        assert!(unpacked(&with((15 << 3) + 1)).is_err());
    }
}
